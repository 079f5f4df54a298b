#include "plugins/cyclonedds/shared_secrets.hpp"

#include <gtest/gtest.h>

#include "plugins/cyclonedds/value_translation.hpp"

namespace ddssec::cyclonedds {
namespace {

using spi::HandshakeHandle;
using spi::IdentityHandle;

spi::SharedSecret secret_of(std::uint8_t octet) {
  spi::SharedSecret secret;
  secret.secret = *spi::SharedSecretOctets::copy_of(Bytes(32, octet));
  return secret;
}

TEST(SharedSecrets, AFloodOfForgedRequests_IsBoundedAndSparesFinishedOnes) {
  SharedSecrets secrets;
  secrets.note({1}, IdentityHandle{10}, IdentityHandle{20});
  const auto finished = secrets.pointer_for({1}, secret_of(7));
  ASSERT_TRUE(finished);
  for (std::int64_t forged = 2; forged < 10'000; ++forged)
    secrets.note({forged}, IdentityHandle{10}, IdentityHandle{20});
  EXPECT_EQ(*secrets.pointer_for({1}, secret_of(8)), *finished);
  EXPECT_EQ(reinterpret_cast<SharedSecretLayout*>(*finished)->shared_secret[0], 7);
  EXPECT_EQ(secrets.pointer_for({2}, secret_of(8)).error().code(), Code::foreign_shared_secret);
  EXPECT_TRUE(secrets.pointer_for({9'999}, secret_of(8)));
}

TEST(SharedSecrets, OnlyTheIdentitysOwn_Go) {
  SharedSecrets secrets;
  secrets.note({1}, IdentityHandle{10}, IdentityHandle{20});
  secrets.note({2}, IdentityHandle{10}, IdentityHandle{21});
  secrets.note({2}, IdentityHandle{10}, IdentityHandle{20});  // it is known and stays where it was
  secrets.drop(IdentityHandle{20});
  EXPECT_FALSE(secrets.pointer_for({1}, secret_of(1)));
  EXPECT_TRUE(secrets.pointer_for({2}, secret_of(1)));
  secrets.drop(IdentityHandle{10});
  EXPECT_FALSE(secrets.pointer_for({2}, secret_of(1)));
}

TEST(SharedSecrets, PeersCiphers_ReachOurCryptographyOnly) {
  SharedSecrets secrets;
  secrets.note({1}, IdentityHandle{10}, IdentityHandle{20});
  auto secret = secret_of(7);
  secret.peer_ciphers = spi::kAllCiphers;
  secret.peer_prefix = GuidPrefix{{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};
  const auto handle = secrets.pointer_for({1}, secret);
  EXPECT_EQ(shared_secret_from(*handle)->peer_ciphers, spi::kAllCiphers);
  EXPECT_EQ(shared_secret_from(*handle)->peer_prefix, secret.peer_prefix);
  EXPECT_EQ(shared_secret_from(*handle)->secret, secret.secret);
  // The same octets in the layout of Cyclone's plugin say nothing about ciphers.
  auto layout = *reinterpret_cast<SharedSecretLayout*>(*handle);
  Bytes octets(32, 7);
  layout.shared_secret = octets.data();
  const auto foreign = reinterpret_cast<DDS_Security_SharedSecretHandle>(&layout);
  EXPECT_EQ(shared_secret_from(foreign)->peer_ciphers, spi::kStandardCiphers);
  EXPECT_FALSE(shared_secret_from(foreign)->peer_prefix);
  EXPECT_EQ(shared_secret_from(foreign)->secret, secret.secret);
}

}  // namespace
}  // namespace ddssec::cyclonedds
