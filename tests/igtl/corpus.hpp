// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "proto/igtl/message_head.hpp"
#include "proto/igtl/opened_message.hpp"

namespace fanlight::test {

/// A message of the corpus (tests/igtl/corpus/write), byte by byte.
inline std::vector<std::uint8_t> corpus_message(const std::string& name) {
  std::ifstream file(std::string(FANLIGHT_IGTL_CORPUS) + "/" + name + ".igtl", std::ios::binary);
  EXPECT_TRUE(file) << name;
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Its time: 2023-11-14 22:13:20.25 UTC.
inline constexpr std::uint64_t kCorpusNs = 1'700'000'000'250'000'000;

}  // namespace fanlight::test
