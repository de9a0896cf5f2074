// SPDX-License-Identifier: Apache-2.0
#include "proto/model/transfer_function.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

namespace fanlight {
namespace {

constexpr std::string_view kDefault = "0 #591f14 0, 60 #804f41 0, 255 #ffebd1 0.3";

/// That many points, from level 0 on, without a trailing comma.
std::string points(std::size_t count) {
  std::string text;
  for (std::size_t level = 0; level < count; ++level) {
    text += fmt::format("{}{} #00ff00 0.5", level == 0 ? "" : ",", level);
  }
  return text;
}

TEST(TransferFunction, WritesItselfAsItReads) {
  EXPECT_EQ(TransferFunction().text(), kDefault);
  const std::string most = TransferFunction::parse(points(TransferFunction::kMostPoints)).value().text();
  for (const std::string_view text :
       {kDefault, std::string_view("7 #abcdef 0.999"),
        std::string_view("0 #000000 1e-07, 255 #ffffff 0.123456789012345"), std::string_view(most)}) {
    const auto read = TransferFunction::parse(text);
    ASSERT_TRUE(read) << text;
    EXPECT_EQ(read->text(), text);
    EXPECT_EQ(TransferFunction::parse(read->text()).value(), *read);
  }
  EXPECT_EQ(TransferFunction::parse(kDefault).value(), TransferFunction());
}

TEST(TransferFunction, ReadsSpacesAndCapitals) {
  const auto read = TransferFunction::parse("  0   #ABCDEF  .5 ,255 #000000 1e-3  ");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->text(), "0 #abcdef 0.5, 255 #000000 0.001");
  ASSERT_EQ(read->points().size(), 2U);
  EXPECT_EQ(read->points()[0].colour, (std::array<std::uint8_t, 3>{0xab, 0xcd, 0xef}));
}

TEST(TransferFunction, DiffersInEveryPart) {
  const auto one = TransferFunction::parse("10 #102030 0.5").value();
  for (const std::string_view text : {"11 #102030 0.5", "10 #112030 0.5", "10 #102130 0.5", "10 #102031 0.5",
                                      "10 #102030 0.6", "10 #102030 0.5, 11 #102030 0.5"}) {
    EXPECT_NE(TransferFunction::parse(text).value(), one) << text;
  }
}

TEST(TransferFunction, IsLinearBetweenPointsAndConstantBeyond) {
  const auto function = TransferFunction::parse("100 #000000 0, 200 #ff8000 0.2, 201 #ffffff 0.9").value();
  const auto expect = [&](double level, std::array<double, 3> levels, double opacity) {
    const TransferFunction::Value value = function.at(level);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      EXPECT_NEAR(value.colour[channel], levels[channel] / 255, 1e-12) << level;
    }
    EXPECT_NEAR(value.opacity_per_mm, opacity, 1e-12) << level;
  };
  for (const double level : {0.0, 99.9, 100.0}) expect(level, {0, 0, 0}, 0);
  expect(150, {127.5, 64, 0}, 0.1);
  expect(112.5, {31.875, 16, 0}, 0.025);
  expect(200, {255, 128, 0}, 0.2);
  expect(200.5, {255, 191.5, 127.5}, 0.55);
  for (const double level : {201.0, 201.1, 255.0}) expect(level, {255, 255, 255}, 0.9);
}

TEST(TransferFunction, IsConstantWithOnePoint) {
  const auto function = TransferFunction::parse("90 #336699 0.25").value();
  for (const double level : {0.0, 90.0, 255.0}) {
    EXPECT_EQ(function.at(level).opacity_per_mm, 0.25);
    EXPECT_NEAR(function.at(level).colour[2], 0x99 / 255.0, 1e-12);
  }
}

struct Refused {
  std::string text;
  std::string_view wrong;  ///< beginning of the message
};

TEST(TransferFunction, RefusesAndSaysWhichPoint) {
  const Refused cases[] = {
      {"", "point 1 cannot be read"},
      {"   ", "point 1 cannot be read"},
      {",", "point 1 cannot be read"},
      {"0 #591f14 0,", "point 2 cannot be read"},
      {"0 #591f14 0,, 255 #591f14 0", "point 2 cannot be read"},
      {points(17), "there are more than 16 points"},
      {"60 #591f14 0, 60 #591f14 0", "the level of point 2 does not rise"},
      {"0 #591f14 0, 60 #591f14 0, 59 #591f14 0", "the level of point 3 does not rise"},
      {"256 #591f14 0", "point 1 cannot be read"},
      {"-1 #591f14 0", "point 1 cannot be read"},
      {"1.5 #591f14 0", "point 1 cannot be read"},
      {"+1 #591f14 0", "point 1 cannot be read"},
      {"x #591f14 0", "point 1 cannot be read"},
      {"0 591f14 0", "point 1 cannot be read"},
      {"0 #591f1 0", "point 1 cannot be read"},
      {"0 #591f144 0", "point 1 cannot be read"},
      {"0 #591f1g 0", "point 1 cannot be read"},
      {"0 #-91f14 0", "point 1 cannot be read"},
      {"0 skin 0", "point 1 cannot be read"},
      {"0 #591f14", "point 1 cannot be read"},
      {"0 #591f14 nan", "point 1 cannot be read"},
      {"0 #591f14 inf", "point 1 cannot be read"},
      {"0 #591f14 1", "point 1 cannot be read"},
      {"0 #591f14 0.9991", "point 1 cannot be read"},
      {"0 #591f14 -0.1", "point 1 cannot be read"},
      {"0 #591f14 0.5x", "point 1 cannot be read"},
      {"0 #591f14 0.5 more", "point 1 cannot be read"},
      {"0\t#591f14\t0", "point 1 cannot be read"},
      {std::string("0 #591f14 0\0", 12), "point 1 cannot be read"},
      {"0 #591f14 0" + std::string(1024, ' '), "the text is longer than 1024 characters"},
  };
  for (const auto& [text, wrong] : cases) {
    const auto refused = TransferFunction::parse(text);
    ASSERT_FALSE(refused) << "took \"" << text << "\"";
    EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
    EXPECT_EQ(refused.error().message,
              fmt::format("{}, expected 1 to 16 points \"LEVEL #RRGGBB OPACITY\" separated by commas, levels "
                          "rising from 0 to 255, opacity 0 to 0.999 per mm",
                          wrong));
  }
}

TEST(TransferFunction, ReadsTheLongestText) {
  const std::string text = "0 #591f14 0";
  EXPECT_TRUE(TransferFunction::parse(text + std::string(1024 - text.size(), ' ')));
}

}  // namespace
}  // namespace fanlight
