// The file with renewed certificates and permissions.
#include "pki/renewal_list.hpp"

#include <gmock/gmock.h>

#include "pki/certificate_source.hpp"
#include "tests/unit/pki/pki_fixture.hpp"

namespace ddssec::pki {
namespace {

using testing::HasSubstr;

const Credential& leaf() {
  static const auto credential = make_leaf(make_ca("CN=CA"), "CN=one");
  return credential;
}

RenewalList two_entries() {
  return {.certificates = {leaf().certificate}, .permissions = {to_bytes(as_bytes("signed text"))}};
}

TEST(RenewalList, WrittenAndRead_IsTheSame) {
  const auto text = two_entries().text();
  ASSERT_OK(text);
  const auto read = RenewalList::parse(as_bytes(*text));
  ASSERT_OK(read);
  EXPECT_EQ(read->certificates, two_entries().certificates);
  EXPECT_EQ(read->permissions, two_entries().permissions);
}

// A file that is being written has fewer whole entries, or is refused.
TEST(RenewalList, CutAtEveryOctet_HasNoOtherEntry) {
  const auto text = two_entries().text().value();
  for (std::size_t size = 0; size < text.size() - 1; ++size) {
    const auto read = RenewalList::parse(as_bytes(text).first(size));
    if (!read) {
      EXPECT_EQ(read.error().code(), Code::renewal_list_malformed);
      continue;
    }
    EXPECT_EQ(read->certificates, two_entries().certificates) << size;
    EXPECT_TRUE(read->permissions.empty() || read->permissions == two_entries().permissions);
  }
}

TEST(RenewalList, TextWithoutABlock_IsRefused) {
  EXPECT_CODE(RenewalList::parse({}), renewal_list_malformed);
  EXPECT_CODE(RenewalList::parse(as_bytes("no block")), renewal_list_malformed);
  const auto none = RenewalList{}.text().value();
  const auto read = RenewalList::parse(as_bytes(none));
  ASSERT_TRUE(read);
  EXPECT_TRUE(read->is_empty());
  EXPECT_CODE(RenewalList::parse(as_bytes(none.substr(1))), renewal_list_malformed);
}

TEST(RenewalList, AnotherBlock_IsRefused) {
  const auto text =
      two_entries().text().value() + "-----BEGIN X509 CRL-----\nAAAA\n-----END X509 CRL-----\n";
  const auto read = RenewalList::parse(as_bytes(text));
  EXPECT_CODE(read, renewal_list_malformed);
  EXPECT_THAT(read.error().to_sentence(), HasSubstr("X509 CRL"));
}

TEST(RenewalList, ADamagedCertificate_IsRefused) {
  EXPECT_CODE(RenewalList::parse(
                  as_bytes("-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n")),
              certificate_malformed);
}

TEST(RenewalList, MoreThanIsRead_IsRefused) {
  EXPECT_CODE(RenewalList::parse(Bytes(kMaxRenewalListOctets + 1, ' ')), renewal_list_malformed);
  RenewalList list;
  list.permissions.assign(kMaxRenewals + 1, to_bytes(as_bytes("x")));
  EXPECT_CODE(RenewalList::parse(as_bytes(list.text().value())), renewal_list_malformed);
  list.permissions.assign(1, Bytes(kMaxSentPermissionsOctets + 1, 'x'));
  EXPECT_CODE(RenewalList::parse(as_bytes(list.text().value())), renewal_list_malformed);
  list.permissions.clear();
  list.certificates.assign(kMaxRenewals, leaf().certificate);
  EXPECT_TRUE(RenewalList::parse(as_bytes(list.text().value())));
}

}  // namespace
}  // namespace ddssec::pki
