// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace fanlight {

/// The terminal that started this program. Where it closes, the kernel or the shell sends SIGHUP, which
/// people also send to have files read again. One thread; each call opens /dev/tty and does not block.
class OwnTerminal {
 public:
  /// Construct it before SIGHUP is ignored: nohup(1) ignores it, so that the program outlives the terminal.
  OwnTerminal();

  /// On SIGHUP: whether the terminal has closed and the program shall end with it.
  bool has_closed() const;

  /// Call it once a second. A program that still runs a second after its terminal closed (disown) runs on
  /// without one.
  void second_passed();

 private:
  bool is_owner_ = false;
  bool was_absent_ = false;
};

}  // namespace fanlight
