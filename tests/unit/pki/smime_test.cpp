#include "pki/smime.hpp"

#include <gmock/gmock.h>

#include "pki/certificate_source.hpp"
#include "pki/openssl.hpp"
#include "pki/pki_access.hpp"
#include "pki/self_signed.hpp"
#include "pki_fixture.hpp"
#include "tests/support/code_of.hpp"
#include "tests/support/seeded_random.hpp"
#include "untimed_signature.hpp"

namespace ddssec::pki {
namespace {

DocumentVerifier verifier_for(std::vector<Certificate> cas) {
  auto verifier = DocumentVerifier::make(std::move(cas));
  EXPECT_TRUE(verifier) << verifier.error().to_sentence();
  return *std::move(verifier);
}

Bytes der_of(CMS_ContentInfo* cms) {
  const BioPtr bio(BIO_new(BIO_s_mem()));
  EXPECT_EQ(i2d_CMS_bio(bio.get(), cms), 1);
  return to_bytes(bio_octets(bio));
}

// Returns a signature by all of `signers`, made with OpenSSL directly.
Bytes odd_signature(const std::vector<Credential>& signers, const EVP_MD* digest,
                    unsigned flags = CMS_DETACHED) {
  const auto content = bytes("Content-Type: text/plain\r\n\r\n<dds>\r\n</dds>\r\n");
  const CmsPtr cms(CMS_sign(nullptr, nullptr, nullptr, nullptr, flags | CMS_BINARY | CMS_PARTIAL));
  for (const auto& signer : signers)
    CMS_add1_signer(cms.get(), impl_of(signer.certificate).x509.get(),
                    impl_of(signer.key).pkey.get(), digest, flags | CMS_BINARY | CMS_PARTIAL);
  const BioPtr data = bio_over(content);
  // Without signers this reports a failure and leaves a structure that can be encoded.
  EXPECT_EQ(CMS_final(cms.get(), data.get(), nullptr, flags | CMS_BINARY), signers.empty() ? 0 : 1)
      << take_openssl_reason();
  return der_of(cms.get());
}

class Smime : public testing::Test {
 protected:
  Result<SignedDocument> check(std::string_view file, WallTime now = kNow) const {
    return verifier_.verify(as_bytes(file), now);
  }
  std::string sign(std::string_view document = "<dds>\n</dds>\n") const {
    return std::string(as_text(*ca_.sign_document(as_bytes(document), kNow, test_random())));
  }
  std::string boundary(const std::string& file) const {
    const auto at = file.find("boundary=\"") + 10;
    return "--" + file.substr(at, file.find('"', at) - at);
  }

  Authority ca_ = make_ca("CN=Permissions CA");
  Credential self_{ca_.certificate(), ca_.key()};
  DocumentVerifier verifier_ = verifier_for({ca_.certificate()});
  std::string file_ = sign();
};

std::string to_lf(std::string text) {
  std::erase(text, '\r');
  return text;
}

std::string to_crlf(const std::string& text) {
  std::string out;
  for (char c : to_lf(text)) out += c == '\n' ? std::string("\r\n") : std::string(1, c);
  return out;
}

TEST_F(Smime, LineEndsOfTheFile_DoNotMatter) {
  for (const auto& file : {file_, to_lf(file_), to_crlf(file_), file_ + std::string(1, '\0')}) {
    const auto document = check(file);
    ASSERT_TRUE(document) << document.error().to_sentence();
    EXPECT_EQ(as_text(document->content()), "<dds>\r\n</dds>\r\n");
    EXPECT_EQ(document->signer_not_after(), kYear.not_after);
  }
}

TEST_F(Smime, ContentWithoutFinalLineBreakOrWithNothing_IsReturnedAsItIs) {
  for (const char* text : {"<dds/>", "", "\r\n", "a\r\n\r\n"}) {
    const auto document = check(sign(text));
    ASSERT_TRUE(document) << document.error().to_sentence();
    EXPECT_EQ(as_text(document->content()), text);
  }
}

// Returns the line of the file, counted from 1, on which `text` begins.
int line_of(std::string_view file, std::string_view text) {
  return 1 + static_cast<int>(std::ranges::count(file.substr(0, file.find(text)), '\n'));
}

TEST_F(Smime, TheLineOfTheContent_IsTheFilesForEveryKindOfLineEnd) {
  for (const auto& file : {file_, to_lf(file_), to_crlf(file_), "X-More: a\r\n" + file_}) {
    const auto document = check(file);
    ASSERT_TRUE(document) << file;
    EXPECT_EQ(document->first_line(), line_of(file, "<dds>"));
    EXPECT_GT(document->first_line(), 4);
  }
}

TEST_F(Smime, AnyChangedOctetOfTheContent_IsSeen) {
  const auto from = file_.find("<dds>");
  for (auto at = from; at < from + 10; ++at) {
    auto changed = file_;
    changed[at] ^= 1;
    // A carriage return stays alone if its line feed is changed.
    EXPECT_EQ(test::code_of(check(changed)),
              file_[at] == '\n' ? Code::smime_malformed : Code::smime_signature_invalid)
        << at;
  }
  EXPECT_CODE(check(replaced(file_, "<dds>", "<ddt>")), smime_signature_invalid);
}

TEST_F(Smime, EachPrefix_IsRefused) {
  const auto end = file_.find_last_not_of("\r\n");
  for (std::size_t size = 0; size < end; ++size)
    EXPECT_THAT(
        test::code_of(check(std::string_view(file_).substr(0, size))),
        testing::AnyOf(Code::smime_malformed, Code::smime_not_multipart, Code::smime_part_count))
        << size;
}

// CVE-2023-24011, T1 (docs/attacks.md): a certificate that chains to the CA is not the CA.
TEST_F(Smime, ALeafOfThePermissionsCa_IsNotThePermissionsCa) {
  const auto leaf = make_leaf(ca_, "CN=talker");
  const auto by_leaf = odd_signature({leaf}, EVP_sha256());
  EXPECT_CODE(check(with_signature(file_, by_leaf)), smime_signer_not_permissions_ca);
  const auto key = *PrivateKey::generate(KeyKind::ec_p256);
  const auto sub = ca_.certify({.subject = "CN=talker",
                                .validity = kYear,
                                .is_ca = true,
                                .key_usage = std::string(kCaKeyUsage)},
                               key, test_random());
  const auto by_sub = odd_signature({{*sub, key}}, EVP_sha256());
  EXPECT_CODE(check(with_signature(file_, by_sub)), smime_signer_not_permissions_ca);
}

TEST_F(Smime, ASubordinateCa_CountsOnlyIfTheFileListsIt) {
  const auto sub = *ca_.subordinate("CN=Sub", {}, kYear, test_random());
  const auto file = *sub.sign_document(as_bytes("x"), kNow, test_random());
  EXPECT_CODE(verifier_.verify(file, kNow), smime_signer_not_permissions_ca);
  EXPECT_TRUE(verifier_for({ca_.certificate(), sub.certificate()}).verify(file, kNow));
  EXPECT_TRUE(verifier_for({sub.certificate()}).verify(file, kNow));
}

TEST_F(Smime, ACaOfTheSameNameAndSerialButAnotherKey_IsNotBelieved) {
  SeededRandom one(7), same(7);
  const auto real = *Authority::create("CN=Twin", {}, kYear, one);
  const auto twin = *Authority::create("CN=Twin", {}, kYear, same);
  ASSERT_EQ(real.certificate().serial(), twin.certificate().serial());
  const auto file = *twin.sign_document(as_bytes("x"), kNow, test_random());
  EXPECT_CODE(verifier_for({real.certificate()}).verify(file, kNow), smime_signature_invalid);
  // If both CAs are listed, the right one of the two candidates is found.
  EXPECT_TRUE(verifier_for({real.certificate(), twin.certificate()}).verify(file, kNow));
}

// CVE-2025-24807, T2 (docs/attacks.md): an expired CA is accepted.
TEST_F(Smime, TheSigner_MustBeValidAtTheTime) {
  EXPECT_CODE(check(file_, kYear.not_after + 1s), certificate_expired);
  EXPECT_CODE(check(file_, kYear.not_before - 1s), certificate_not_yet_valid);
  const auto root = make_ca("CN=Root", {}, {kNow - 48h, kNow + 24h});
  const auto sub = *root.subordinate("CN=Sub", {}, kYear, test_random());
  const auto file = *sub.sign_document(as_bytes("x"), kNow, test_random());
  const auto verifier = verifier_for({root.certificate(), sub.certificate()});
  EXPECT_TRUE(verifier.verify(file, kNow));
  EXPECT_CODE(verifier.verify(file, kNow + 25h), certificate_expired);
}

TEST_F(Smime, TheSignersKeyUsage_MustAllowSignatures) {
  const auto key = *PrivateKey::generate(KeyKind::ec_p256);
  const auto self = *self_sign(
      {.subject = "CN=CA", .validity = kYear, .is_ca = true, .key_usage = "keyCertSign,cRLSign"},
      key, test_random());
  const auto ca = *Authority::load(self.certificate, self.key);
  const auto file = *ca.sign_document(as_bytes("x"), kNow, test_random());
  EXPECT_CODE(verifier_for({self.certificate}).verify(file, kNow), key_usage_forbids);
}

TEST(SmimeSetUp, ALeafInTheCaFile_IsRefused) {
  const auto ca = make_ca();
  EXPECT_CODE(DocumentVerifier::make({ca.certificate(), make_leaf(ca).certificate}), not_a_ca);
}

// T10 (docs/attacks.md): the text that is read must be the text that was signed.
TEST_F(Smime, TextAroundTheTwoParts_IsRefused) {
  const auto mark = boundary(file_);
  EXPECT_CODE(check(replaced(file_, "This is an S/MIME", "<dds>evil</dds>\nThis is an S/MIME")),
              smime_surrounding_text);
  EXPECT_CODE(check(replaced(file_, "signed message\n", "signed message <dds/>\n")),
              smime_surrounding_text);
  EXPECT_CODE(check(file_ + "<dds>evil</dds>"), smime_surrounding_text);
  EXPECT_TRUE(check(replaced(file_, "This is an S/MIME signed message\n", "")));
}

// Otherwise the peer that sends the document could add megabytes of such text.
TEST_F(Smime, MoreUnsignedOctetsThanToolsWrite_AreRefused) {
  const auto mark = boundary(file_);
  const auto with = [&](std::string_view at, std::string_view more, std::size_t times) {
    std::string octets;
    for (std::size_t i = 0; i < times; ++i) octets += more;
    return replaced(file_, at, std::string(at) + octets);
  };
  for (const std::string_view at : {"signed message\n", "smime.p7s\"\n\n"}) {
    EXPECT_TRUE(check(with(at, "\n", 500))) << at;
    EXPECT_CODE(check(with(at, "\n", 5000)), smime_unsigned_octets);
  }
  EXPECT_TRUE(check(file_ + std::string(500, '\n')));
  EXPECT_CODE(check(file_ + std::string(5000, '\n')), smime_unsigned_octets);
  EXPECT_CODE(check(with(mark, " ", 5000)), smime_malformed);
  EXPECT_CODE(check(with("<dds>", "\r", 5000)), smime_unsigned_octets);
  EXPECT_CODE(check(with("MIME-Version: 1.0\n", "X-Padding: " + std::string(500, 'x') + "\n", 9)),
              smime_unsigned_octets);
  EXPECT_CODE(check(with("smime.p7s\"\n\n", "\n", 70'000)), smime_signature_malformed);
}

TEST_F(Smime, ALongDocumentOfWindows_IsRead) {
  std::string document;
  for (int i = 0; i < 20'000; ++i) document += "<a/>\n";
  std::string lf = sign(document), windows;
  std::erase(lf, '\r');
  for (const char c : lf) windows += c == '\n' ? "\r\r\n" : std::string(1, c);
  EXPECT_TRUE(check(windows));
}

TEST_F(Smime, OtherThanTwoParts_AreRefused) {
  const auto mark = boundary(file_);
  const std::string extra = mark + "\nContent-Type: text/plain\n\n<dds>evil</dds>\n";
  EXPECT_CODE(
      check(replaced(file_, mark + "\nContent-Type: text", extra + mark + "\nContent-Type: text")),
      smime_part_count);
  EXPECT_CODE(check(replaced(file_, mark + "--", mark)), smime_part_count);
  EXPECT_CODE(check(replaced(file_, mark + "\nContent-Type: app", mark + "--\nContent-Type: app")),
              smime_part_count);
  EXPECT_CODE(check(replaced(file_, mark + "\n", mark + " junk\n")), smime_malformed);
}

TEST_F(Smime, NestedAndOtherTypes_AreRefused) {
  EXPECT_CODE(check(replaced(file_, "text/plain", "multipart/mixed; boundary=x")),
              smime_content_type);
  EXPECT_CODE(check(replaced(file_, "text/plain", "text/xml")), smime_content_type);
  EXPECT_CODE(check(replaced(file_, "text/plain", "text/plain; charset=utf-16")),
              smime_content_type);
  EXPECT_CODE(check(replaced(file_, "Content-Type: text/plain\r\n",
                             "Content-Type: text/plain\r\nContent-Transfer-Encoding: base64\r\n")),
              smime_content_type);
  EXPECT_CODE(check(replaced(file_, "Content-Type: text/plain\r\n", "")), smime_content_type);
  EXPECT_CODE(check(replaced(file_, "Encoding: base64", "Encoding: 8bit")), smime_content_type);
  EXPECT_CODE(
      check(replaced(file_, "protocol=\"application/x-pkcs7", "protocol=\"application/pgp")),
      smime_content_type);
  EXPECT_CODE(check(replaced(file_, "boundary=\"", "boundary=x; boundary=\"")), smime_content_type);
}

TEST_F(Smime, UnsignedAndOpaqueDocuments_AreRefused) {
  EXPECT_CODE(check("<?xml version=\"1.0\"?>\n<dds/>\n"), smime_not_multipart);
  EXPECT_CODE(check(""), smime_not_multipart);
  EXPECT_CODE(check("Content-Type: application/pkcs7-mime; smime-type=signed-data\n\nMIIB\n"),
              smime_not_multipart);
}

// The path may be a link to any file that the process may read, so its content must not get into an
// error.
TEST_F(Smime, WhatIsNoDocument_IsNotQuoted) {
  const auto silent = [&](const std::string& text) {
    const auto proof = check(text);
    ASSERT_FALSE(proof) << text;
    EXPECT_EQ(proof.error().to_sentence().find("hunter2"), std::string::npos)
        << proof.error().to_sentence();
  };
  for (const auto* text :
       {"hunter2\n", "root:$6$hunter2:1:2\n", "A: b\nhunter2\n", "A: hunter2\x01\n", "<hunter2>\n",
        "-----BEGIN hunter2\n", "Content-Type: hunter2\n\n",
        "Content-Type: text/plain\n hunter2\n\n", "Content-Type: multipart/signed; hunter2\n\n",
        "Content-Type: multipart/signed; protocol=hunter2; boundary=x\n\n"})
    silent(text);
  const auto mark = boundary(file_);
  silent(replaced(file_, mark + "\n", mark + " hunter2\n"));
  silent(replaced(file_, "Encoding: base64", "Encoding: hunter2"));
  silent(replaced(file_, "text/plain", "text/plain; charset=hunter2"));
  silent(replaced(file_, "Content-Type: text/plain\r\n", "hunter2\r\n"));
  EXPECT_NE(check("<dds/>").error().message().find("an XML document that is not signed"),
            std::string::npos);
}

TEST_F(Smime, OddHeaders_AreRefused) {
  EXPECT_CODE(check(replaced(file_, "MIME-Version", "Content-Type: text/plain\nMIME-Version")),
              smime_malformed);
  EXPECT_CODE(check(replaced(file_, "boundary=\"", "boundary=\"" + std::string(80, 'x'))),
              smime_malformed);
  EXPECT_TRUE(check(replaced(file_, "; micalg", ";\n\tmicalg")));
}

// Stock products and other tools read with OpenSSL, which would find other lines in these headers.
TEST_F(Smime, HeadersThatReadersReadDifferently_AreRefused) {
  const auto with = [&](const std::string& line) {
    return check(replaced(file_, "MIME-Version", line + "\nMIME-Version"));
  };
  EXPECT_TRUE(with("X-Filler: " + std::string(988, 'x')));
  EXPECT_CODE(with("X-Filler: " + std::string(989, 'x')), smime_malformed);
  EXPECT_CODE(with("X-Filler: a\n " + std::string(1022, 'x')), smime_malformed);
  EXPECT_CODE(check(replaced(file_, "Content-Type: multipart",
                             boundary(file_) + ": x\nContent-Type: multipart")),
              smime_malformed);
  EXPECT_CODE(with("X-Filler: a\rb"), smime_malformed);
  EXPECT_CODE(with("X-Filler: a\x1b[2J"), smime_malformed);
}

TEST_F(Smime, NulAndLoneCarriageReturn_AreRefused) {
  EXPECT_CODE(check(replaced(file_, "<dds>", std::string_view("<d\0s>", 5))), smime_nul);
  EXPECT_CODE(check(replaced(file_, "<dds>", "<d\rs>")), smime_malformed);
  EXPECT_CODE(ca_.sign_document(as_bytes("a\rb"), kNow, test_random()), smime_malformed);
  EXPECT_CODE(ca_.sign_document(as_bytes(std::string_view("\0", 1)), kNow, test_random()),
              smime_nul);
}

// OpenSSL on Windows writes the text with CR CR LF and the rest with CRLF, and signs it with CRLF.
// It removes every CR before an LF, so further ones change nothing either.
TEST_F(Smime, CarriageReturnsBeforeALineFeed_AreOneLineBreak) {
  std::string lf = file_;
  std::erase(lf, '\r');
  for (const std::string_view line_break : {"\n", "\r\n", "\r\r\n", "\r\r\r\n"}) {
    std::string text;
    for (const char c : lf) text += c == '\n' ? std::string(line_break) : std::string(1, c);
    const auto document = check(text);
    ASSERT_TRUE(document) << document.error().to_sentence();
    EXPECT_EQ(as_text(document->content()).find("\r\r"), std::string_view::npos);
  }
}

TEST_F(Smime, ABinarySignature_IsNamed) {
  const auto der = check(std::string("0\x82\0\x10", 4));
  ASSERT_FALSE(der);
  EXPECT_EQ(der.error().code(), Code::smime_not_multipart);
  EXPECT_NE(der.error().message().find("a binary (DER) signature"), std::string::npos);
}

TEST_F(Smime, Size_IsBounded) {
  EXPECT_CODE(check(std::string(kMaxDocumentOctets + 1, 'x')), smime_too_large);
}

TEST_F(Smime, TheSignatureStructure_IsChecked) {
  const auto other_ca = make_ca("CN=Other");
  const Credential other{other_ca.certificate(), other_ca.key()};
  EXPECT_TRUE(check(with_signature(file_, odd_signature({self_}, EVP_sha256()))));
  EXPECT_TRUE(check(
      with_signature(file_, odd_signature({self_}, EVP_sha512(), CMS_DETACHED | CMS_NOCERTS))));
  EXPECT_TRUE(check(
      with_signature(file_, odd_signature({self_}, EVP_sha256(), CMS_DETACHED | CMS_NOATTR))));
  EXPECT_CODE(check(with_signature(file_, odd_signature({}, EVP_sha256()))), smime_no_signer);
  EXPECT_CODE(check(with_signature(file_, odd_signature({self_, other}, EVP_sha256()))),
              smime_several_signers);
  EXPECT_CODE(check(with_signature(file_, odd_signature({other}, EVP_sha256()))),
              smime_signer_not_permissions_ca);
  EXPECT_CODE(check(with_signature(file_, odd_signature({self_}, EVP_sha1()))),
              smime_digest_too_weak);
  // The content is inside the signature, a form that OpenSSL calls opaque.
  EXPECT_CODE(check(with_signature(file_, odd_signature({self_}, EVP_sha256(), 0))),
              smime_signature_malformed);
  EXPECT_CODE(check(with_signature(file_, bytes("junk"))), smime_signature_malformed);
  auto trailing = odd_signature({self_}, EVP_sha256());
  trailing.push_back(0);
  EXPECT_CODE(check(with_signature(file_, trailing)), smime_signature_malformed);
  EXPECT_CODE(check(replaced(file_, "p7s\"\n\nM", "p7s\"\n\n!")), smime_signature_malformed);
}

TEST_F(Smime, AnyFlippedBitOfTheSignature_IsRefused) {
  const auto good = odd_signature({self_}, EVP_sha256(), CMS_DETACHED | CMS_NOCERTS | CMS_NOATTR);
  ASSERT_TRUE(check(with_signature(file_, good)));
  int accepted = 0;
  for (std::size_t at = 0; at < good.size(); ++at) {
    auto changed = good;
    changed[at] ^= 1;
    accepted += check(with_signature(file_, changed)).has_value() ? 1 : 0;
  }
  // Only the two version numbers mean nothing to a verifier.
  EXPECT_EQ(accepted, 2);
}

}  // namespace
}  // namespace ddssec::pki
