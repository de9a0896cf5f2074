// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/fuzz_targets.hpp"

namespace fanlight::test {
namespace {

struct Target {
  std::string name;  // also the name of its corpus folder
  void (*run)(std::span<const std::uint8_t> input);
};

std::ostream& operator<<(std::ostream& stream, const Target& target) {
  return stream << target.name;
}

class Corpus : public testing::TestWithParam<Target> {
 protected:
  static std::vector<std::vector<std::uint8_t>> inputs() {
    std::vector<std::vector<std::uint8_t>> stored;
    const std::filesystem::path folder = std::filesystem::path(FANLIGHT_CORPUS_FOLDER) / GetParam().name;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      std::ifstream file(entry.path(), std::ios::binary);
      stored.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    }
    return stored;
  }
};

TEST_P(Corpus, RunsEveryStoredInput) {
  const auto stored = inputs();
  ASSERT_GE(stored.size(), 5U) << "the corpus is missing";
  for (const auto& input : stored) GetParam().run(input);
}

// Random mutations without feedback from code coverage; tests/fuzz/run mutates with it.
TEST_P(Corpus, RunsMutationsOfEveryInput) {
  std::mt19937 random(4);
  const auto stored = inputs();
  for (int round = 0; round < 40; ++round) {
    for (auto input : stored) {
      for (unsigned change = random() % 8; change > 0 && !input.empty(); --change) {
        const std::size_t index = random() % input.size();
        switch (random() % 3) {
          case 0:
            input[index] = static_cast<std::uint8_t>(random());
            break;
          case 1:
            input.erase(input.begin() + static_cast<std::ptrdiff_t>(index));
            break;
          default:
            input.insert(input.begin() + static_cast<std::ptrdiff_t>(index),
                         static_cast<std::uint8_t>(random()));
            break;
        }
      }
      GetParam().run(input);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Fuzz, Corpus,
                         testing::Values(Target{"client_messages", &fuzz_client_messages},
                                         Target{"frame_parser", &fuzz_frame_parser},
                                         Target{"probe_blocks", &fuzz_probe_blocks},
                                         Target{"recording", &fuzz_recording},
                                         Target{"segment", &fuzz_segment}),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace fanlight::test
