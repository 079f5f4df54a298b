#include "pki/renewal_request.hpp"

#include <gtest/gtest.h>

#include "pki_fixture.hpp"

namespace ddssec::pki {
namespace {

struct RenewalRequestTest : testing::Test {
  Authority ca = make_ca();
  Credential talker = make_leaf(ca, "CN=talker,O=Example");
  Credential other = make_leaf(ca, "CN=listener,O=Example");

  std::string request(const PrivateKey& key, const Certificate& of) const {
    const auto out = make_request(key, of);
    EXPECT_TRUE(out);
    return out.value_or("");
  }
  Status check(std::string_view pem, RequestedKey key) const {
    return check_renewal_request(as_bytes(pem), talker.certificate, key);
  }
};

TEST_F(RenewalRequestTest, OwnKeyAndSubject_AreAccepted) {
  const auto pem = request(talker.key, talker.certificate);
  EXPECT_TRUE(check(pem, RequestedKey::same));
  EXPECT_TRUE(check(pem, RequestedKey::any));
  const auto issued = ca.sign_request(as_bytes(pem), kYear, test_random());
  ASSERT_TRUE(issued);
  EXPECT_EQ(issued->subject_digest(), talker.certificate.subject_digest());
}

TEST_F(RenewalRequestTest, AnotherKey_IsAcceptedOnlyIfAnyMayBe) {
  const auto pem = request(other.key, talker.certificate);
  EXPECT_CODE(check(pem, RequestedKey::same), key_mismatch);
  EXPECT_TRUE(check(pem, RequestedKey::any));
}

TEST_F(RenewalRequestTest, AnotherSubject_IsRefused) {
  const auto pem = request(talker.key, other.certificate);
  EXPECT_CODE(check(pem, RequestedKey::same), request_invalid);
  EXPECT_CODE(check(pem, RequestedKey::any), request_invalid);
}

TEST_F(RenewalRequestTest, SubjectInAnotherCase_IsRefused) {
  const auto pem = make_request(talker.key, "CN=Talker,O=Example");
  ASSERT_TRUE(pem);
  EXPECT_CODE(check(*pem, RequestedKey::any), request_invalid);
}

TEST_F(RenewalRequestTest, RequestCutShort_IsRefused) {
  const auto pem = request(talker.key, talker.certificate);
  for (std::size_t size = 0; size + 30 < pem.size(); size += 7)
    EXPECT_CODE(check(std::string_view(pem).substr(0, size), RequestedKey::any), request_invalid);
}

}  // namespace
}  // namespace ddssec::pki
