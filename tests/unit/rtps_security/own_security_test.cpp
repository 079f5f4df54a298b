// Reasons for which no participant is made.
#include "rtps/security/own_security.hpp"

#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr Rules kHidden{.rtps_psk = kEncrypt};

TEST(PreSharedKey, ParticipantWithoutAPassphrase_IsNotCreated) {
  Node node(9);
  const PluginServices services{node.clock, node.random, node.events};
  const auto authentication = authentication::make_authentication(services);
  const auto access_control =
      access_control::make_access_control(services, {.host_has_pre_shared_keys = true});
  const auto cryptography = cryptography::make_cryptography(services);
  const auto refused = OwnSecurity::create({{*authentication, *access_control, *cryptography},
                                            properties_of("CN=alice,O=Example", kHidden)},
                                           0, Node::candidate(9));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), Code::missing_property);
  EXPECT_NE(refused.error().to_sentence().find(spi::property::kPskPassphrase), std::string::npos);
}

}  // namespace
}  // namespace ddssec::rtps
