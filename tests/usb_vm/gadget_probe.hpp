// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "proto/exchange/doorbell.hpp"
#include "tests/usb/probe_core.hpp"
#include "tests/usb_vm/bulk_writes.hpp"
#include "tests/usb_vm/configfs_gadget.hpp"
#include "tests/usb_vm/function_fs.hpp"

namespace fanlight::test {

/// ProbeModel behind a real USB device controller, with the faults of a FaultScript and injected ones; the
/// counterpart on a kernel's bus of UsbfsProbe (tests/usb). It cannot make a transfer fail or overflow: the
/// faults error and overflow have no effect. The kernel buffers up to a MiB of frames that the host has not
/// read. Where these are cancelled (stall, start, stop) or lost by an unplug, the model's counters count them
/// as sent. A value that the model refuses is ignored and not stalled, see FunctionFs::take().
///
/// Life: created unplugged -> plug() -> unplug() -> plug() -> ... All functions from any thread.
class GadgetProbe {
 public:
  struct Config {
    ProbeModel::Config model;
    std::string faults;  ///< FaultScript, started by the first plug
  };
  /// kInvalidArgument where a value is out of its range or the script is not valid, kUnavailable where this
  /// machine cannot emulate a device.
  static Result<std::unique_ptr<GadgetProbe>> create(const Config& config);
  ~GadgetProbe();
  GadgetProbe(const GadgetProbe&) = delete;
  GadgetProbe& operator=(const GadgetProbe&) = delete;

  // Both return the time just before the kernel was called, and return when it has finished. No effect where
  // the probe is already plugged in, or unplugged.
  std::int64_t plug();  ///< 0 where the kernel refused
  std::int64_t unplug();

  /// Unplug and replug are finished before it returns.
  void inject(const Fault& fault);

  ProbeModel::Counters counters();

 private:
  GadgetProbe(std::unique_ptr<ProbeCore> core, ConfigfsGadget gadget, FunctionFs function,
              std::unique_ptr<BulkWrites> writes);

  std::int64_t plug_locked();
  std::int64_t unplug_locked();
  void fulfil_plug_wish();

  // One thread each.
  void follow_script(const std::stop_token& stop);
  void serve_control(const std::stop_token& stop);
  void serve_pipe(const std::stop_token& stop);

  void serve(const usb_ctrlrequest& request);
  void serve_in(const usb_ctrlrequest& request);
  void serve_out(const usb_ctrlrequest& request);
  bool wait_while_mute(const usb_ctrlrequest& request, const std::stop_token& stop);
  void end_stream();
  std::int64_t fill_pipe();
  void stall();

  const std::unique_ptr<ProbeCore> core_;
  // Accessed under core's lock, except the events and answers of function_, which belong to the control
  // thread.
  FunctionFs function_;
  std::unique_ptr<BulkWrites> writes_;
  ConfigfsGadget gadget_;
  std::size_t begun_bytes_ = 0;     // of the next write: a transfer that is neither ended nor full
  bool owes_empty_packet_ = false;  // a transfer whose last packet was full must be ended
  bool script_began_ = false;

  Doorbell pipe_bell_;
  Doorbell control_bell_;
  std::jthread control_;  // last members: they end first
  std::jthread pipe_;
  std::jthread follower_;
};

}  // namespace fanlight::test
