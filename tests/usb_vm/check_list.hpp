#pragma once

#include <functional>
#include <string>

namespace fanlight::test {

/// Checks that are carried out one after the other, whatever came of those before. Prints a line for each as
/// soon as it is known. One thread.
class CheckList {
 public:
  /// `check` returns what it saw ("ok   ..."), or throws a std::exception with what is wrong ("FAILED ...").
  void run(const std::string& name, const std::function<std::string()>& check);
  /// Checks that belong together, and what they need; where that throws, the rest of them is a failure.
  void section(const std::string& name, const std::function<void()>& checks);

  bool all_passed() const { return failures_ == 0; }

 private:
  int failures_ = 0;
};

/// Throws std::runtime_error with that text where it does not hold.
void require(bool holds, const std::string& otherwise);

}  // namespace fanlight::test
