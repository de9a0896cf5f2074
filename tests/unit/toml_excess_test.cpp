// SPDX-License-Identifier: Apache-2.0
// Which texts are not given to the TOML parser.
#include "proto/base/toml_excess.hpp"

#include <gtest/gtest.h>

namespace fanlight::test {
namespace {

std::string repeated(const char* part, int times) {
  std::string text;
  for (int i = 0; i < times; ++i) text += part;
  return text;
}

TEST(TomlExcess, TakesWhatConfigurationsHave) {
  EXPECT_EQ(toml_excess(""), "");
  EXPECT_EQ(toml_excess("[serve]\nlisten = \"127.0.0.1:8080\"\nlight.up_mm = 20.5\n"), "");
  EXPECT_EQ(toml_excess("values = [" + repeated("1.5, ", 10'000) + "]\n"), "");
  EXPECT_EQ(toml_excess(repeated("[[recording]]\npath = \"a.b.c\"\n", 10'000)), "");
}

TEST(TomlExcess, LooksAtNoStringAndNoComment) {
  EXPECT_EQ(toml_excess("# " + repeated("[", 100) + "\na = 1"), "");
  EXPECT_EQ(toml_excess("a = \"" + repeated("[.", 100) + "\""), "");
  EXPECT_EQ(toml_excess("a = \"\\\"" + repeated("{", 100) + "\""), "");
  EXPECT_EQ(toml_excess("a = '" + repeated("{", 100) + "'"), "");
  EXPECT_EQ(toml_excess("a = '''\n" + repeated("{'", 100) + "'''"), "");
  EXPECT_NE(toml_excess("a = [\"\"\"x\"\"\"\", " + repeated("[", 100)), "") << "four quotes end it too";
  EXPECT_NE(toml_excess("a = \"open\nb = " + repeated("[", 100)), "") << "a line end ends a string";
}

TEST(TomlExcess, RefusesNesting) {
  EXPECT_EQ(toml_excess("a = " + repeated("[", 17)), "more than 16 brackets are open at once");
  EXPECT_EQ(toml_excess(repeated("a={", 40'000)), "more than 16 brackets are open at once");
  EXPECT_EQ(toml_excess("a" + repeated(".a", 16) + " = 1"), "a key has more than 16 parts");
  EXPECT_EQ(toml_excess("[a" + repeated(".a", 50'000) + "]"), "a key has more than 16 parts");
}

}  // namespace
}  // namespace fanlight::test
