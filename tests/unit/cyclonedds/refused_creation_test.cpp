// Participants whose creation access control refuses. The host returns none of their handles.
#include "plugins/cyclonedds/refused_creation.hpp"

#include "plugins/cyclonedds/authentication_adapter.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds {
namespace {

using testing::_;
using testing::Return;

struct RefusedCreation : testing::Test {
  // Makes the calls of the host until one is refused. Returns whether the participant was created.
  bool create(std::int64_t local, bool admits) {
    ON_CALL(plugin, participant_sec_attributes).WillByDefault([admits](auto) {
      return spi::ParticipantSecurityAttributes{.allow_unauthenticated_participants = admits};
    });
    ON_CALL(plugin, validate_local_permissions)
        .WillByDefault(Return(spi::PermissionsHandle{local + 100}));
    const auto permissions = c->validate_local_permissions(c, auth, local, 5, &qos, nullptr);
    if (permissions == DDS_SECURITY_HANDLE_NIL) return false;
    DDS_Security_ParticipantSecurityAttributes attributes{};
    return c->check_create_participant(c, permissions, 5, &qos, nullptr) &&
           c->get_participant_sec_attributes(c, permissions, &attributes, nullptr);
  }

  Harness<AccessControlAdapter, MockAccessControl, spi::AccessControl> harness;
  Harness<AuthenticationAdapter, MockAuthentication, spi::Authentication> authentication;
  dds_security_access_control* c = &harness.adapter;
  dds_security_authentication* auth = &authentication.adapter;
  MockAccessControl& plugin = *harness.plugin;
  DDS_Security_Qos qos{};
};

TEST_F(RefusedCreation, ParticipantThatMustBeAlone_LeavesNothingInEitherPlugin) {
  EXPECT_TRUE(create(1, false));
  for (std::int64_t local = 2; local < 5; ++local) {
    EXPECT_CALL(plugin, return_permissions_handle(spi::PermissionsHandle{local + 100}));
    EXPECT_CALL(*authentication.plugin, return_identity_handle(spi::IdentityHandle{local}));
    EXPECT_FALSE(create(local, true));
  }
  EXPECT_EQ(harness.adapter.facts().locals(), std::vector{spi::PermissionsHandle{101}});
}

TEST_F(RefusedCreation, ParticipantThatMayNotJoin_LeavesNothingInEitherPlugin) {
  ON_CALL(plugin, check_create_participant)
      .WillByDefault(Return(fail(Code::participant_not_allowed)));
  EXPECT_CALL(plugin, return_permissions_handle(spi::PermissionsHandle{102}));
  EXPECT_CALL(*authentication.plugin, return_identity_handle(spi::IdentityHandle{2}));
  EXPECT_FALSE(create(2, false));
  EXPECT_TRUE(harness.adapter.facts().locals().empty());
}

TEST_F(RefusedCreation, ParticipantWithoutValidDocuments_LeavesNoIdentity) {
  ON_CALL(plugin, validate_local_permissions).WillByDefault([](auto&&...) {
    return Result<spi::PermissionsHandle>(fail(Code::domain_not_covered));
  });
  EXPECT_CALL(*authentication.plugin, return_identity_handle(spi::IdentityHandle{2}));
  EXPECT_EQ(c->validate_local_permissions(c, auth, 2, 5, &qos, nullptr), 0);
}

TEST_F(RefusedCreation, ParticipantThatIsCreated_KeepsItsHandles) {
  EXPECT_CALL(plugin, return_permissions_handle).Times(0);
  EXPECT_CALL(*authentication.plugin, return_identity_handle).Times(0);
  EXPECT_TRUE(create(1, false));
  EXPECT_TRUE(create(2, false));
}

// Another host than Cyclone DDS may return the handles. They are unknown by then, and nothing is
// given up for them again.
TEST_F(RefusedCreation, HandlesThatTheHostReturnsToo_AreUnknown) {
  EXPECT_TRUE(create(1, false));
  EXPECT_FALSE(create(2, true));
  EXPECT_CALL(plugin, return_permissions_handle(spi::PermissionsHandle{102}))
      .WillOnce(Return(fail(Code::unknown_permissions_handle)));
  EXPECT_CALL(*authentication.plugin, return_identity_handle(spi::IdentityHandle{2}))
      .WillOnce(Return(fail(Code::unknown_identity)));
  EXPECT_EQ(c->return_permissions_handle(c, 102, nullptr), 0);
  EXPECT_EQ(auth->return_identity_handle(auth, 2, nullptr), 0);
  EXPECT_EQ(harness.adapter.facts().locals(), std::vector{spi::PermissionsHandle{101}});
}

TEST_F(RefusedCreation, ParticipantForWhichThereIsNoMemory_IsNotGivenUp) {
  EXPECT_TRUE(create(1, false));
  EXPECT_CALL(plugin, return_permissions_handle).Times(0);
  EXPECT_CALL(*authentication.plugin, return_identity_handle).Times(0);
  EXPECT_FALSE(or_give_up(harness.adapter, {101}, fail(Code::out_of_memory)));
  EXPECT_EQ(harness.adapter.facts().locals().size(), 1u);
}

TEST_F(RefusedCreation, HostWithoutAuthentication_IsServed) {
  auth = nullptr;
  EXPECT_TRUE(create(1, false));
  EXPECT_CALL(plugin, return_permissions_handle(spi::PermissionsHandle{102}));
  EXPECT_FALSE(create(2, true));
}

}  // namespace
}  // namespace ddssec::cyclonedds
