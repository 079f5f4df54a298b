#include "base/text.hpp"

#include <gtest/gtest.h>

namespace ddssec {
namespace {

TEST(Text, OnlyAsciiLetters_ChangeTheirCase) {
  EXPECT_EQ(ascii_upper(std::string_view("aZ09_\xc3\xa9[`{z")), "AZ09_\xc3\xa9[`{Z");
  EXPECT_EQ(ascii_lower(std::string_view("aZ09_\xc3\x89@[`A")), "az09_\xc3\x89@[`a");
  EXPECT_EQ(ascii_upper(std::string_view()), "");
}

TEST(Text, NamedCharacters_AreTrimmed) {
  EXPECT_EQ(trimmed(" \tone two\t ", " \t"), "one two");
  EXPECT_EQ(trimmed(" \t ", " \t"), "");
  EXPECT_EQ(trimmed("\none", " "), "\none");
}

TEST(Text, ControlCharacters_BecomeQuestionMarks) {
  EXPECT_EQ(printable("CN=a\nb\033[31m\x7f, \xc3\xa4"), "CN=a?b?[31m?, \xc3\xa4");
}

TEST(Text, WhatATerminalWouldObeyOrReorder_IsEscaped) {
  EXPECT_EQ(printable("\xc2\x9b"
                      "31m"),
            "\\u009b31m");  // C1: CSI
  EXPECT_EQ(printable("\xc2\x80\xc2\x9f\xc2\xa0"), "\\u0080\\u009f\xc2\xa0");
  EXPECT_EQ(printable("a\xe2\x80\xae"
                      "b\xe2\x81\xa6"),
            "a\\u202eb\\u2066");  // RLO, LRI
  EXPECT_EQ(printable("\xe2\x80\x8e\xe2\x80\x8f"), "\\u200e\\u200f");
  EXPECT_EQ(printable("\xe2\x80\xa8\xef\xbb\xbf"), "\\u2028\\ufeff");
  // These characters have no glyph.
  EXPECT_EQ(printable("\xc2\xad\xe2\x81\xa0\xe1\xa0\x8e"), "\\u00ad\\u2060\\u180e");
  EXPECT_EQ(printable("a\xf3\xa0\x81\x81\xf3\xa0\x81\xbf"), "a\\U000e0041\\U000e007f");  // tags
  EXPECT_EQ(printable("\xf0\x9f\xa4\x96 \xd7\xa9"), "\xf0\x9f\xa4\x96 \xd7\xa9");  // letters stay
}

TEST(Text, OctetsThatAreNotUtf8_AreEscaped) {
  EXPECT_EQ(printable("\x9b"
                      "31m"),
            "\\x9b31m");
  EXPECT_EQ(printable("\xc3"), "\\xc3");                             // cut short
  EXPECT_EQ(printable("\xc0\x9b"), "\\xc0\\x9b");                    // overlong
  EXPECT_EQ(printable("\xe0\x82\x9b"), "\\xe0\\x82\\x9b");           // overlong
  EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80");           // a surrogate
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");  // above U+10FFFF
  EXPECT_EQ(printable("\xc3"
                      "ab"),
            "\\xc3"
            "ab");
}

TEST(Text, WhatIsWanted_IsPrintedAsItIs) {
  EXPECT_EQ(printable("a\tb\n\033[1m", {.keeps_line_feeds = true}), "a\tb\n?[1m");
  EXPECT_EQ(printable("a\n\033[1m", {.keeps_escapes = true}), "a?\033[1m");
  EXPECT_EQ(printable("\xc3\xa4\xc2\x9b", {.keeps_utf8 = false}), "\\xc3\\xa4\\u009b");
}

TEST(Text, FirstMisleadingCharacter_IsFound) {
  EXPECT_EQ(first_misleading("rt/\xc3\xa4"), std::nullopt);
  EXPECT_EQ(first_misleading("rt/\xc3\xa4\xe2\x80\xae\x01"), char32_t{0x202e});
  EXPECT_EQ(first_misleading("rt/\x7f"), char32_t{0x7f});
  EXPECT_EQ(first_misleading("rt/\xff"), char32_t{0xfffd});
}

TEST(Text, Distance_CountsInsertionsRemovalsChangesAndSwaps) {
  EXPECT_EQ(edit_distance("", ""), 0u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("abc", ""), 3u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
  EXPECT_EQ(edit_distance("lawn", "flaw"), 2u);
  EXPECT_EQ(edit_distance("same", "same"), 0u);
  EXPECT_EQ(edit_distance("tarck", "track"), 1u);
  EXPECT_EQ(edit_distance("ab", "ba"), 1u);
  EXPECT_EQ(edit_distance("abcd", "badc"), 2u);
}

TEST(ArgumentPointers, Texts_ArePointedIntoAndEndWithNull) {
  std::vector<std::string> texts{"one", ""};
  const auto pointers = argument_pointers(texts);
  ASSERT_EQ(pointers.size(), 3U);
  EXPECT_EQ(pointers[0], texts[0].data());
  EXPECT_STREQ(pointers[1], "");
  EXPECT_EQ(pointers[2], nullptr);
}

}  // namespace
}  // namespace ddssec
