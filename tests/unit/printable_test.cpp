// SPDX-License-Identifier: Apache-2.0
// Text from outside: what may be shown on a terminal, in a log and on a page.
#include <gtest/gtest.h>

#include "proto/base/printable.hpp"

namespace fanlight::test {
namespace {

TEST(Printable, LeavesTextOfAnyScriptAsItIs) {
  for (const char* text : {"", "theatre 3", "OP-Saal Süd \"2\"", "手術室", "операционная", "غرفة العمليات",
                           "\xF0\x9F\x94\xAC lab", "می\xE2\x80\x8Cخواهم",
                           "a\xC2\xA0"
                           "b",
                           "\xEE\x80\x80"}) {
    EXPECT_TRUE(is_printable(text)) << text;
    EXPECT_EQ(printable(text), text);
  }
}

TEST(Printable, ReplacesControlsOfTerminalsAndOfTheDirection) {
  struct Case {
    std::string text;
    std::string shown;
  };
  const std::vector<Case> cases = {
      {"a\nb", "a?b"},
      {"a\tb\rc", "a?b?c"},
      {std::string("a\0b", 3), "a?b"},
      {"\x1B[31mred", "?[31mred"},
      {"\x7F", "?"},
      {"\xC2\x9B"
       "31mred",
       "?31mred"},                          // C1: control sequence introducer
      {"\xC2\x85next line", "?next line"},  // C1: next line
      {"\xE2\x80\xAE"
       "evil\xE2\x80\xAC",
       "?evil?"},                                    // right-to-left override, pop
      {"\xE2\x81\xA6x\xE2\x81\xA9", "?x?"},          // isolates
      {"\xE2\x80\x8F\xD8\x9C", "??"},                // marks of direction
      {"\xE2\x80\xA8\xE2\x80\xA9", "??"},            // line and paragraph separator
      {"ad\xE2\x80\x8Bmin\xEF\xBB\xBF", "ad?min?"},  // zero width space, byte order mark
      {"\xF3\xA0\x81\x81", "?"},                     // tag
      {"\xEF\xBF\xBF", "?"},                         // no character
  };
  for (const Case& one : cases) {
    EXPECT_FALSE(is_printable(one.text)) << one.shown;
    EXPECT_EQ(printable(one.text), one.shown);
    EXPECT_TRUE(is_printable(printable(one.text)));
  }
}

TEST(Printable, ReplacesEachByteThatIsNoUtf8) {
  struct Case {
    std::string text;
    std::string shown;
  };
  const std::vector<Case> cases = {
      {"\xFFz", "?z"},  // no lead byte
      {"\x9B"
       "31m",
       "?31m"},                           // C1 as one byte, as Latin-1 terminals read it
      {"\xC3", "?"},                      // cut off
      {"\xE2\x80", "??"},                 // cut off
      {"\xC3(", "?("},                    // no continuation
      {"\xC0\x8A", "??"},                 // a line feed, longer than needed
      {"\xE0\x82\x9B", "???"},            // a C1 control, longer than needed
      {"\xED\xA0\x80", "???"},            // surrogate
      {"\xF4\x90\x80\x80", "????"},       // beyond the last character
      {"\xF8\x88\x80\x80\x80", "?????"},  // five bytes
  };
  for (const Case& one : cases) {
    EXPECT_FALSE(is_printable(one.text)) << one.shown;
    EXPECT_EQ(printable(one.text), one.shown);
  }
}

}  // namespace
}  // namespace fanlight::test
