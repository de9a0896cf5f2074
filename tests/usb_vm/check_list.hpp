// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

namespace fanlight::test {

/// Executes checks one after the other, also after a failure. Prints a line for each result at once. One
/// thread.
class CheckList {
 public:
  /// `check` returns a description ("ok   ..."), or throws a std::exception with the reason ("FAILED ...").
  void run(const std::string& name, const std::function<std::string()>& check);
  /// Checks with common preparations; where these throw, the remaining checks fail.
  void section(const std::string& name, const std::function<void()>& checks);

  bool all_passed() const { return failures_ == 0; }

 private:
  int failures_ = 0;
};

/// Throws std::runtime_error with this text unless `holds`.
void require(bool holds, const std::string& otherwise);

}  // namespace fanlight::test
