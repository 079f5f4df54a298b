#include "pki/document_parts.hpp"

#include "tests/unit/pki/pki_fixture.hpp"

namespace ddssec::pki {
namespace {

TEST(DocumentParts, EachPart_HasTheCertificatesFields) {
  const auto ca = make_ca();
  const auto leaf = make_leaf(ca).certificate;
  const auto part = part_of(leaf);
  EXPECT_EQ(part.subject, "CN=talker,O=Example");
  EXPECT_EQ(part.number, leaf.serial());
  EXPECT_EQ(part.until, kYear.not_after);
  EXPECT_EQ(part.sha256, to_hex(leaf.fingerprint()));
}

TEST(DocumentParts, SeveralCertificates_AreInTheirOrder) {
  const auto ca = make_ca();
  const auto one = make_leaf(ca, "CN=one").certificate, two = make_leaf(ca, "CN=two").certificate;
  const auto parts = parts_of({two, one});
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].subject, "CN=two");
  EXPECT_EQ(parts[1].subject, "CN=one");
}

}  // namespace
}  // namespace ddssec::pki
