// SPDX-License-Identifier: Apache-2.0
#include "tests/usb/fault_script.hpp"

#include <gtest/gtest.h>

#include "tests/support/milliseconds.hpp"

namespace fanlight::test {
namespace {

constexpr std::int64_t kBegin = 5'000 * kMs;

FaultScript begun(std::string_view text) {
  auto script = FaultScript::parse(text);
  EXPECT_TRUE(script) << script.error().message;
  script->begin(kBegin);
  return std::move(*script);
}

std::vector<FaultKind> kinds(const std::vector<Fault>& faults) {
  std::vector<FaultKind> kinds;
  for (const Fault& fault : faults) kinds.push_back(fault.kind);
  return kinds;
}
using Kinds = std::vector<FaultKind>;

TEST(FaultScriptTest, NothingHappensInAnEmptyOne) {
  auto script = begun("  ");
  EXPECT_FALSE(script.next_ns());
  EXPECT_TRUE(script.due(kBegin + 1'000'000 * kMs).empty());
  EXPECT_TRUE(script.before_frame(7, kBegin).empty());
}

TEST(FaultScriptTest, TimesCountFromTheBeginningAndFromThePartBefore) {
  auto script = begun("at 2s unplug; after 300ms replug; at 1s drop");
  EXPECT_EQ(script.next_ns(), kBegin + 1000 * kMs);
  EXPECT_TRUE(script.due(kBegin + 999 * kMs).empty());
  EXPECT_EQ(kinds(script.due(kBegin + 1000 * kMs)), Kinds{FaultKind::kDrop});
  EXPECT_EQ(kinds(script.due(kBegin + 2010 * kMs)), Kinds{FaultKind::kUnplug});
  EXPECT_EQ(script.next_ns(), kBegin + 2300 * kMs) << "a late unplug does not delay what follows";
  EXPECT_EQ(kinds(script.due(kBegin + 2300 * kMs)), Kinds{FaultKind::kReplug});
  EXPECT_FALSE(script.next_ns());
}

TEST(FaultScriptTest, WhatIsLateComesAllAtOnceAndInOrder) {
  auto script = begun("at 2s unplug; after 300ms replug; every 1s cut");
  EXPECT_EQ(kinds(script.due(kBegin + 2500 * kMs)),
            (Kinds{FaultKind::kCut, FaultKind::kUnplug, FaultKind::kCut, FaultKind::kReplug}));
}

TEST(FaultScriptTest, FramesCountWhateverTheTime) {
  auto script = begun("frame 40 damage; frame 40 noise 12; after 100ms stall; every 30 frames drop");
  EXPECT_FALSE(script.next_ns());
  EXPECT_TRUE(script.before_frame(29, kBegin).empty());
  EXPECT_EQ(kinds(script.before_frame(30, kBegin)), Kinds{FaultKind::kDrop});
  EXPECT_TRUE(script.before_frame(30, kBegin).empty()) << "asked twice";
  const auto faults = script.before_frame(40, kBegin + 50 * kMs);
  ASSERT_EQ(kinds(faults), (Kinds{FaultKind::kDamage, FaultKind::kNoise}));
  EXPECT_EQ(faults[1].bytes, 12U);
  EXPECT_EQ(script.next_ns(), kBegin + 150 * kMs);
  EXPECT_EQ(kinds(script.before_frame(60, kBegin)), Kinds{FaultKind::kDrop});
}

TEST(FaultScriptTest, RepeatRestartsWhenAllHasHappened) {
  auto script = begun("at 2s unplug; after 300ms replug; repeat");
  for (int round = 0; round < 3; ++round) {
    EXPECT_EQ(script.next_ns(), kBegin + (2000 + round * 2300) * kMs);
    EXPECT_EQ(kinds(script.due(*script.next_ns())), Kinds{FaultKind::kUnplug});
    EXPECT_EQ(kinds(script.due(*script.next_ns())), Kinds{FaultKind::kReplug});
  }
}

TEST(FaultScriptTest, RepeatCountsFramesFromTheRoundsBeginning) {
  auto script = begun("frame 10 cut; repeat");
  EXPECT_EQ(kinds(script.before_frame(10, kBegin)), Kinds{FaultKind::kCut});
  EXPECT_TRUE(script.before_frame(19, kBegin).empty());
  EXPECT_EQ(kinds(script.before_frame(20, kBegin)), Kinds{FaultKind::kCut});
}

TEST(FaultScriptTest, EveryFaultHasItsWord) {
  for (const FaultWord& fault : fault_words()) {
    std::string text = "at 1s " + std::string(fault.word);
    if (fault.argument == FaultWord::Argument::kBytes) text += " 5";
    if (fault.argument == FaultWord::Argument::kDuration) text += " 5ms";
    auto script = begun(text);
    const auto faults = script.due(kBegin + 1000 * kMs);
    ASSERT_EQ(faults.size(), 1U) << text;
    EXPECT_EQ(faults[0].kind, fault.kind) << text;
    EXPECT_EQ(fault_words()[static_cast<std::size_t>(fault.kind)].word, fault.word);
  }
}

TEST(FaultScriptTest, QuotesWhatItDoesNotUnderstand) {
  for (const std::string text :
       {"drop", "at drop", "at 5 drop", "at 5m drop", "at -5s drop", "at 99999999s drop", "at 5s",
        "at 5s explode", "at 5s drop drop", "at 5s noise", "at 5s noise much", "at 5s silent 5", "frame drop",
        "frame x drop", "every 0s drop", "every 0 frames drop", "every 5 frames", "after 5s drop"}) {
    const auto script = FaultScript::parse("at 1s cut; every 1s cut; " + text + " ; at 7s drop");
    ASSERT_FALSE(script) << text;
    EXPECT_EQ(script.error().code, ErrorCode::kInvalidArgument);
    EXPECT_NE(script.error().message.find('"' + text + '"'), std::string::npos) << script.error().message;
  }
  EXPECT_FALSE(FaultScript::parse("at 1s drop; repeat; at 2s drop"));
  EXPECT_FALSE(FaultScript::parse("repeat"));
  EXPECT_FALSE(FaultScript::parse("at 0s drop; repeat")) << "would never end";
}

}  // namespace
}  // namespace fanlight::test
