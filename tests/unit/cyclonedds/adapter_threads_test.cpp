// Identities end while other threads are in the middle of a handshake. The host returns a revoked
// identity from within the revocation, as Cyclone's core does.
#include <atomic>
#include <thread>

#include "plugins/cyclonedds/authentication_adapter.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds {
namespace {

// A plugin whose identities all end at the next look, and whose handshakes succeed at once.
struct Mortal : MockAuthentication {
  std::atomic<std::int64_t> last_identity = 0, last_handshake = 0;
  std::shared_ptr<spi::SharedSecret> secret = std::make_shared<spi::SharedSecret>();

  Result<HandshakeStep> begin_handshake_request(spi::IdentityHandle, spi::IdentityHandle,
                                                BytesView) override {
    return HandshakeStep{
        {++last_handshake}, spi::ValidationResult::pending_handshake_message, sample_token()};
  }
  Result<std::shared_ptr<const spi::SharedSecret>> shared_secret(spi::HandshakeHandle) override {
    return secret;
  }
  Status return_identity_handle(spi::IdentityHandle) override { return {}; }
  std::optional<WallTime> next_expiry() override { return WallTime(); }
  std::vector<spi::IdentityHandle> poll(spi::IdentityHandle) override {
    return {{last_identity.load()}};
  }
};

std::atomic<int> revocations = 0;

Guid guid_of(std::int64_t remote) {
  Guid guid{{{0x80}}, kEntityIdParticipant};
  for (int i = 0; i < 8; ++i)
    guid.prefix.octets[4 + i] = static_cast<std::uint8_t>(remote >> (8 * i));
  return guid;
}

TEST(AdapterThreads, IdentitiesThatEndDuringHandshakes_AreRevoked) {
  Harness<AuthenticationAdapter, Mortal, spi::Authentication> harness;
  harness.plugin->secret->secret = *spi::SharedSecretOctets::copy_of(Bytes(32, 9));
  auto* c = static_cast<dds_security_authentication*>(&harness.adapter);
  const dds_security_authentication_listener listener{
      [](const dds_security_authentication* plugin,
         const DDS_Security_IdentityHandle handle) -> DDS_Security_boolean {
        auto& mine = AuthenticationAdapter::of(const_cast<dds_security_authentication&>(*plugin));
        ++revocations;
        return mine.return_identity_handle(&mine, handle, nullptr);
      },
      nullptr};
  ASSERT_EQ(c->set_listener(c, &listener, nullptr), 1);

  std::vector<std::thread> threads;
  for (int i = 0; i < 3; ++i)
    threads.emplace_back([&] {
      const HostOctets data(Bytes(8, 1));
      for (int round = 0; round < 300 || revocations < 2; ++round) {
        const auto remote = ++harness.plugin->last_identity;
        harness.adapter.remotes().note({1}, guid_of(remote), {remote});
        DDS_Security_HandshakeHandle handshake = 0;
        DDS_Security_DataHolder message{};
        EXPECT_EQ(
            c->begin_handshake_request(c, &handshake, &message, 1, remote, &data.sequence, nullptr),
            DDS_SECURITY_VALIDATION_PENDING_HANDSHAKE_MESSAGE);
        free_token(message);
        // The result is nil if the identity has ended in the meantime.
        c->get_shared_secret(c, handshake, nullptr);
        c->return_identity_handle(c, remote, nullptr);
      }
    });
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(c->set_listener(c, nullptr, nullptr), 1);
  EXPECT_GE(revocations, 2);
}

}  // namespace
}  // namespace ddssec::cyclonedds
