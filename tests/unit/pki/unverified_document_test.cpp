// A signed document before its signature is verified.
#include "pki/unverified_document.hpp"

#include <algorithm>

#include "tests/unit/pki/pki_fixture.hpp"

namespace ddssec::pki {
namespace {

class UnverifiedDocumentTest : public testing::Test {
 protected:
  static const std::string& file() {
    static const std::string signed_text = [] {
      const auto octets = make_ca().sign_document(as_bytes("<dds>\n</dds>\n"), kNow, test_random());
      return std::string(as_text(octets.value()));
    }();
    return signed_text;
  }
  static Result<UnverifiedDocument> read(std::string_view text) {
    return read_document(as_bytes(text));
  }
  // Returns the file with `change` made in its base64 text.
  template <class F>
  static std::string with_base64(F&& change) {
    auto text = file();
    std::erase(text, '\r');
    const auto begin = text.find("\n\n", text.rfind("Content-")) + 2;
    const auto end = text.find("\n--", begin);
    auto base64 = text.substr(begin, end - begin);
    change(base64);
    return text.replace(begin, end - begin, base64);
  }
};

TEST_F(UnverifiedDocumentTest, TextAndLine_AreThoseOfTheFile) {
  const auto document = read(file());
  ASSERT_OK(document);
  EXPECT_EQ(as_text(document->text()), "<dds>\r\n</dds>\r\n");
  const auto before = std::string_view(file()).substr(0, file().find("<dds>"));
  EXPECT_EQ(document->first_line, 1 + std::ranges::count(before, '\n'));
  EXPECT_EQ(document->signature.front(), 0x30);
}

TEST_F(UnverifiedDocumentTest, OneNulAtTheEnd_IsToleratedAndNoOther) {
  using namespace std::string_literals;
  EXPECT_TRUE(read(file() + "\0"s));
  EXPECT_CODE(read(file() + "\0\0"s), smime_nul);
  EXPECT_CODE(read("\0"s + file()), smime_nul);
  EXPECT_CODE(read("\x30\0\0"s), smime_not_multipart);
}

TEST_F(UnverifiedDocumentTest, Base64_HasOneForm) {
  EXPECT_TRUE(read(with_base64([](std::string&) {})));
  EXPECT_TRUE(read(with_base64([](std::string& text) { text.insert(10, " \t\n"); })));
  for (const std::string wrong : {"=", "==AA", "*", "-", "A"})
    EXPECT_CODE(read(with_base64([&](std::string& text) { text.insert(8, wrong); })),
                smime_signature_malformed);
  EXPECT_CODE(read(with_base64([](std::string& text) { text = "===="; })),
              smime_signature_malformed);
  EXPECT_CODE(read(with_base64([](std::string& text) { text = "A==="; })),
              smime_signature_malformed);
  EXPECT_CODE(read(with_base64([](std::string& text) { text.clear(); })),
              smime_signature_malformed);
  EXPECT_CODE(read(with_base64([](std::string& text) { text.assign(70'000, 'A'); })),
              smime_signature_malformed);
}

TEST_F(UnverifiedDocumentTest, UnsignedOctetsBeyondTheUsual_AreRefused) {
  EXPECT_TRUE(read(with_base64([](std::string& text) { text += std::string(3'000, '\n'); })));
  EXPECT_CODE(read(with_base64([](std::string& text) { text += std::string(5'000, '\n'); })),
              smime_unsigned_octets);
}

}  // namespace
}  // namespace ddssec::pki
