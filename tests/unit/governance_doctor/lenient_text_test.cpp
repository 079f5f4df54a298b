// Documents as stock products read them.
#include "governance/doctor/lenient_text.hpp"

#include <gtest/gtest.h>

#include "governance/doctor/measured_outcomes.hpp"

namespace ddssec::governance::doctor {
namespace {

struct Text {
  std::string given;
  std::string left;
  std::vector<Variant> left_out;
};

std::string blanks(std::string_view text) { return std::string(text.size(), ' '); }

TEST(LenientText, WhatStockProductsSkip_IsBlankedOutAndNamed) {
  using enum Variant;
  const std::string doctype = R"(<!DOCTYPE d [<!ENTITY a "">]>)";
  const std::string dashes = "<!-- a--b -->";
  const std::string declaration = R"(<?xml version=\"1.0\" encoding=\"utf-8\"?>)";
  for (const auto& [given, left, left_out] : {
           Text{"<dds/>", "<dds/>", {}},
           Text{"<dds><!-- a --></dds>", "<dds><!-- a --></dds>", {}},
           Text{doctype + "<d/>", blanks(doctype) + "<d/>", {governance_doctype}},
           Text{"<?a\n b?><d/>", "   \n    <d/>", {governance_processing_instruction}},
           Text{"<d>" + dashes + "</d>",
                "<d>" + blanks(dashes) + "</d>",
                {governance_comment_dashes}},
           Text{declaration + "<d/>", blanks(declaration) + "<d/>", {governance_escaped_quotes}},
           Text{"<d>\xE4</d>", "<d>?</d>", {governance_latin_1}},
           Text{"<!DOCTYPE", "         ", {governance_doctype}},
           Text{"<!--", "<!--", {}},
           Text{"", "", {}},
       }) {
    const auto out = lenient_text(as_bytes(std::string_view(given)));
    EXPECT_EQ(as_text(out.text), left) << given;
    EXPECT_EQ(out.left_out, left_out) << given;
  }
}

}  // namespace
}  // namespace ddssec::governance::doctor
