// SPDX-License-Identifier: Apache-2.0
#include "tests/usb_vm/check_list.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <stdexcept>

namespace fanlight::test {

void CheckList::run(const std::string& name, const std::function<std::string()>& check) {
  try {
    const std::string seen = check();
    fmt::print("ok     {}: {}\n", name, seen);
  } catch (const std::exception& failure) {
    ++failures_;
    fmt::print("FAILED {}: {}\n", name, failure.what());
  }
  std::fflush(stdout);
}

void CheckList::section(const std::string& name, const std::function<void()>& checks) {
  fmt::print("-- {}\n", name);
  try {
    checks();
  } catch (const std::exception& failure) {
    ++failures_;
    fmt::print("FAILED {}: {}\n", name, failure.what());
  }
  std::fflush(stdout);
}

void require(bool holds, const std::string& otherwise) {
  if (!holds) throw std::runtime_error(otherwise);
}

}  // namespace fanlight::test
