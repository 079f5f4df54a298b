// Addresses of OCSP responders, which a peer's certificate may name.
#include "pki/ocsp_address.hpp"

#include "base/tool_code.hpp"
#include "tests/unit/pki/pki_fixture.hpp"

namespace ddssec::pki {
namespace {

TEST(OcspAddress, Address_IsTakenApart) {
  const auto whole = parse_ocsp_address("http://ocsp.example:8080/a/b");
  ASSERT_OK(whole);
  EXPECT_EQ(whole->host, "ocsp.example");
  EXPECT_EQ(whole->port, "8080");
  EXPECT_EQ(whole->path, "/a/b");
  const auto brief = parse_ocsp_address("http://ocsp.example");
  ASSERT_OK(brief);
  EXPECT_EQ(brief->port, "80");
  EXPECT_EQ(brief->path, "/");
}

TEST(OcspAddress, AnythingButPlainHttp_IsRefused) {
  for (const char* const bad :
       {"", "https://ocsp.example/", "ldap://ocsp.example/", "ocsp.example/a", "http://",
        "http://:80/", "http://ocsp.example:port/", "http://ocsp.example/a b",
        "http://ocsp.example/\r\nHost: other", "http://ocsp.example/\x7f", "http://\xc3\xa4/"}) {
    const auto refused = parse_ocsp_address(bad);
    ASSERT_FALSE(refused) << bad;
    EXPECT_EQ(refused.error().code(), tool_code::ocsp_fetch_failed) << bad;
    EXPECT_EQ(refused.error().details().found, bad);
    EXPECT_FALSE(refused.error().details().note.empty()) << bad;
  }
}

TEST(OcspAddress, CertificateThatNamesNone_HasNone) {
  const auto ca = make_ca();
  EXPECT_EQ(ocsp_responder_of(make_leaf(ca).certificate), "");
}

}  // namespace
}  // namespace ddssec::pki
