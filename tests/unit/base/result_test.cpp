#include "base/result.hpp"

#include <gtest/gtest.h>

namespace ddssec {
namespace {

TEST(Error, Sentence_SaysDocumentLineBothValuesAndWhatToDo) {
  const Error error(Code::invalid_property, {.document = "governance.xml",
                                             .line = 12,
                                             .field = "domain id",
                                             .expected = "0 to 230",
                                             .found = "300"});
  const auto text = error.to_sentence();
  for (const char* part : {"governance.xml, line 12, domain id: ", "expected 0 to 230, found 300",
                           "correct the property's value", "[invalid_property 1011]"})
    EXPECT_NE(text.find(part), text.npos) << text;
}

TEST(Error, OwnHint_ReplacesTheCodesHint) {
  const Error error(Code::invalid_property, {.hint = "set it to 3"});
  EXPECT_EQ(error.hint(), "set it to 3");
  EXPECT_NE(error.to_sentence().find("; set it to 3 [invalid_property"), std::string::npos);
  EXPECT_EQ(Error(Code::invalid_property).hint(), info(Code::invalid_property).hint);
}

TEST(Error, FirstDocumentNamed_IsKept) {
  const Error inner(Code::truncated, {.document = "c.id"});
  EXPECT_EQ(inner.with_default_document("handshake request").details().document, "c.id");
  EXPECT_EQ(Error(Code::truncated).with_default_document("handshake request").details().document,
            "handshake request");
}

TEST(Error, ValueThatIsKnown_IsNamed) {
  EXPECT_TRUE(Error(Code::malformed, {.expected = "1"}).message().ends_with(" (expected 1)"));
  EXPECT_TRUE(Error(Code::malformed, {.found = "2"}).message().ends_with(" (found 2)"));
  EXPECT_TRUE(Error(Code::malformed, {.note = "why"}).message().ends_with("; why"));
  EXPECT_EQ(Error(Code::malformed).message(), info(Code::malformed).summary);
}

// Parts of the sentence come from files and peers.
TEST(Error, ControlCharactersOfAValue_DoNotReachALog) {
  const auto text = Error(Code::malformed, {.document = "a\nb", .found = "\033[31m"}).to_sentence();
  EXPECT_TRUE(text.starts_with("a?b: ")) << text;
  EXPECT_EQ(text.find('\033'), text.npos) << text;
}

Result<int> half(int value) {
  if (value % 2 != 0) return fail(Code::malformed);
  return value / 2;
}
Result<int> quarter(int value) {
  DDSSEC_ASSIGN_OR_RETURN(const auto halved, half(value));
  return half(halved);
}

TEST(Result, FailedTry_ReturnsTheFirstError) {
  EXPECT_EQ(quarter(8), 2);
  EXPECT_EQ(quarter(6).error().code(), Code::malformed);
}

}  // namespace
}  // namespace ddssec
