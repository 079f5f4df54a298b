// What OpenSSL could not make for lack of memory is made at the next call. This is a program of its
// own, because the first creation in a process counts.
#include <algorithm>

#include <gtest/gtest.h>

#include "pki/key_agreement.hpp"
#include "pki/private_key.hpp"
#include "tests/support/failing_memory.hpp"

namespace ddssec::pki {
namespace {

using failing_memory::Extent;
using failing_memory::Source;

// The base point of P-256 (SEC 2 2.4.2).
constexpr std::string_view kPoint =
    "046b17d1f2e12c4247f8bce6e563a440f277037d812deb33a0f4a13945d898c296"
    "4fe342e2fe1a7f9b8ee7eb4a7c0f9e162bce33576b315ececbb6406837bf51f5";

TEST(PkiOutOfMemory, FailureAtTheFirstPublicKey_DoesNotSpoilTheNext) {
  ASSERT_TRUE(PrivateKey::generate(KeyKind::ec_p256, 0));  // starts OpenSSL
  const auto octets = from_hex(kPoint);
  ASSERT_TRUE(octets);
  const auto sources = failing_memory::sources();
  const bool openssl_can_fail = std::ranges::find(sources, Source::c) != sources.end();
  if (openssl_can_fail) failing_memory::fail_at(Source::c, Extent::from_then_on, 1);
  const auto refused = PeerPublicKey::parse(KeyAgreementKind::ecdh_p256, *octets);
  EXPECT_EQ(failing_memory::stop_failing(), openssl_can_fail);
  EXPECT_EQ(refused.has_value(), !openssl_can_fail);
  EXPECT_TRUE(PeerPublicKey::parse(KeyAgreementKind::ecdh_p256, *octets));
}

}  // namespace
}  // namespace ddssec::pki
