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
  std::string name;  // also the folder of its corpus
  void (*run)(std::span<const std::uint8_t> input);
};

std::ostream& operator<<(std::ostream& to, const Target& target) {
  return to << target.name;
}

class Corpus : public testing::TestWithParam<Target> {
 protected:
  static std::vector<std::vector<std::uint8_t>> inputs() {
    std::vector<std::vector<std::uint8_t>> read;
    const std::filesystem::path folder = std::filesystem::path(FANLIGHT_CORPUS_FOLDER) / GetParam().name;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      std::ifstream file(entry.path(), std::ios::binary);
      read.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    }
    return read;
  }
};

TEST_P(Corpus, EveryInputThatWasKept) {
  const auto kept = inputs();
  ASSERT_GE(kept.size(), 5U) << "the corpus is not there";
  for (const auto& input : kept) GetParam().run(input);
}

// What a fuzzer would do without a look at the code that it runs: tests/fuzz/run does better.
TEST_P(Corpus, ChangesOfEveryInput) {
  std::mt19937 random(4);
  const auto kept = inputs();
  for (int round = 0; round < 40; ++round) {
    for (auto input : kept) {
      for (unsigned change = random() % 8; change > 0 && !input.empty(); --change) {
        const std::size_t at = random() % input.size();
        switch (random() % 3) {
          case 0:
            input[at] = static_cast<std::uint8_t>(random());
            break;
          case 1:
            input.erase(input.begin() + static_cast<std::ptrdiff_t>(at));
            break;
          default:
            input.insert(input.begin() + static_cast<std::ptrdiff_t>(at),
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
                                         Target{"probe_blocks", &fuzz_probe_blocks}),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace fanlight::test
