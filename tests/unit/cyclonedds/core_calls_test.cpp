// Calls of authentication that Cyclone's core makes, with a handshake in the core's layout.
#include <dlfcn.h>
#include <memory>

#include "plugins/cyclonedds/authentication_adapter.hpp"
#include "plugins/cyclonedds/core_handshake.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds {
namespace {

using testing::Return;

// A handshake of Cyclone's core that asks an adapter about a peer.
struct CallOfCore {
  CallOfCore() {
    handshake->plugin = &adapter;
    handshake->domain = adapter.gv;
    handshake->machine = &machine;
    handshake->remote.fill(0x81818181);
    handshake->remote[3] = 0x000001c1;
    machine.argument = handshake.get();
  }
  ~CallOfCore() {
    free_token(handshake->local_auth_request);
    dlclose(library);
  }
  CallOfCore(const CallOfCore&) = delete;
  CallOfCore& operator=(const CallOfCore&) = delete;

  DDS_Security_ValidationResult_t ask(DDS_Security_DataHolder& request,
                                      const DDS_Security_DataHolder& token) {
    DDS_Security_IdentityHandle handle = 0;
    const Guid peer{{{0x81, 0x81, 0x81, 0x81, 0x81, 0x81, 0x81, 0x81, 0x81, 0x81, 0x81, 0x81}},
                    kEntityIdParticipant};
    const auto guid = to_c(peer);
    return adapter.validate_remote_identity(&adapter, &handle, &request, nullptr, 1, &token, &guid,
                                            nullptr);
  }

  std::vector<Event> events;
  testing::NiceMock<MockAuthentication>* plugin = nullptr;
  void* const library = dlopen(DDSSEC_CORE_LIKE, RTLD_LOCAL | RTLD_NOW);
  AuthenticationAdapter adapter{
      std::make_unique<Host>(std::make_unique<Recorder>(events),
                             dlsym(library, "dds_security_fsm_set_timeout")),
      [this](const PluginServices&) {
        auto made = std::make_unique<testing::NiceMock<MockAuthentication>>();
        plugin = made.get();
        return std::unique_ptr<spi::Authentication>(std::move(made));
      },
      reinterpret_cast<ddsi_domaingv*>(&events)};
  CoreStateMachine machine{};
  std::unique_ptr<CoreHandshake> handshake = std::make_unique<CoreHandshake>();
};

// The core would leak the token, and strangers choose its size and how often one comes.
TEST(AuthenticationAdapterOfCore, RefusedIdentityToken_IsFreedForTheCore) {
  CallOfCore core;
  DDS_Security_DataHolder token{}, request{};
  ASSERT_TRUE(copy_token(sample_token(), token));
  EXPECT_CALL(*core.plugin, validate_remote_identity)
      .WillOnce(Return(fail(Code::too_many_remote_identities)))
      .WillRepeatedly(Return(fail(Code::guid_not_adjusted)));
  EXPECT_EQ(core.ask(core.handshake->local_auth_request, token),
            DDS_SECURITY_VALIDATION_PENDING_RETRY);
  EXPECT_FALSE(is_nil(&token)) << "the core frees it";
  EXPECT_EQ(core.ask(request, token), DDS_SECURITY_VALIDATION_FAILED);
  EXPECT_FALSE(is_nil(&token)) << "another caller keeps its token";
  EXPECT_EQ(core.ask(core.handshake->local_auth_request, token), DDS_SECURITY_VALIDATION_FAILED);
  EXPECT_TRUE(is_nil(&token));
  EXPECT_EQ(token.properties._buffer, nullptr);
  EXPECT_EQ(token.binary_properties._buffer, nullptr);
  free_token(request);
}

}  // namespace
}  // namespace ddssec::cyclonedds
