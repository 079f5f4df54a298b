#include "base/text.hpp"

#include <gtest/gtest.h>

namespace ddssec {
namespace {

TEST(Text, OnlyAsciiLettersChangeTheirCase) {
  EXPECT_EQ(ascii_upper(std::string_view("aZ09_\xc3\xa9[`{z")), "AZ09_\xc3\xa9[`{Z");
  EXPECT_EQ(ascii_lower(std::string_view("aZ09_\xc3\x89@[`A")), "az09_\xc3\x89@[`a");
  EXPECT_EQ(ascii_upper(std::string_view()), "");
}

TEST(Text, IsTrimmedOfWhatOneNames) {
  EXPECT_EQ(trimmed(" \tone two\t ", " \t"), "one two");
  EXPECT_EQ(trimmed(" \t ", " \t"), "");
  EXPECT_EQ(trimmed("\none", " "), "\none");
}

TEST(Text, WhatATerminalMustNotSee) {
  EXPECT_EQ(printable("CN=a\nb\033[31m\x7f, \xc3\xa4"), "CN=a?b?[31m?, \xc3\xa4");
}

TEST(Text, DistanceCountsInsertionsRemovalsAndChanges) {
  EXPECT_EQ(edit_distance("", ""), 0u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("abc", ""), 3u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
  EXPECT_EQ(edit_distance("lawn", "flaw"), 2u);
  EXPECT_EQ(edit_distance("same", "same"), 0u);
}

}  // namespace
}  // namespace ddssec
