// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
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

/// All of them, in the order of their names.
inline std::vector<std::vector<std::uint8_t>> corpus_messages() {
  std::vector<std::string> names;
  for (const auto& file : std::filesystem::directory_iterator(FANLIGHT_IGTL_CORPUS))
    if (file.path().extension() == ".igtl") names.push_back(file.path().stem());
  std::ranges::sort(names);
  std::vector<std::vector<std::uint8_t>> messages;
  messages.reserve(names.size());
  for (const std::string& name : names) messages.push_back(corpus_message(name));
  return messages;
}

/// Its time: 2023-11-14 22:13:20.25 UTC.
inline constexpr std::uint64_t kCorpusNs = 1'700'000'000'250'000'000;

}  // namespace fanlight::test
