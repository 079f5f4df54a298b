// The tokens of filter expressions.
#include "rtps/filter/lexer.hpp"

#include <gmock/gmock.h>

#include "tests/support/code_of.hpp"

namespace ddssec::rtps {
namespace {

using Kind = FilterToken::Kind;
using ::testing::ElementsAre;

std::vector<Kind> kinds(std::string_view expression) {
  FilterLexer lexer(expression);
  std::vector<Kind> out;
  for (auto token = lexer.next(); token && token->kind != Kind::end; token = lexer.next())
    out.push_back(token->kind);
  return out;
}

TEST(FilterLexer, EachKind_IsRecognised) {
  EXPECT_THAT(kinds("speed.x >= 0x1F and not (name like 'a%')"),
              ElementsAre(Kind::field, Kind::relation, Kind::integer, Kind::and_, Kind::not_,
                          Kind::open, Kind::field, Kind::like, Kind::text, Kind::close));
  EXPECT_THAT(kinds("a BETWEEN -1.5 AND %0 OR b = TRUE"),
              ElementsAre(Kind::field, Kind::between, Kind::real, Kind::and_, Kind::parameter,
                          Kind::or_, Kind::field, Kind::relation, Kind::true_));
}

TEST(FilterLexer, Token_HasItsTextAndPosition) {
  FilterLexer lexer("ab <> 'it'");
  const auto field = lexer.next(), relation = lexer.next(), text = lexer.next();
  ASSERT_TRUE(field);
  ASSERT_TRUE(relation);
  ASSERT_TRUE(text);
  EXPECT_EQ(field->text, "ab");
  EXPECT_EQ(relation->text, "<>");
  EXPECT_EQ(relation->position, 4u);
  EXPECT_EQ(text->text, "it") << "without its quotes";
}

TEST(FilterLexer, WhatIsNoToken_IsRefused) {
  for (const auto* bad : {"'without an end", "%", "%100", "#", "0x"}) {
    FilterLexer lexer(bad);
    EXPECT_EQ(test::code_of(lexer.next()), Code::rtps_filter_invalid) << bad;
  }
}

}  // namespace
}  // namespace ddssec::rtps
