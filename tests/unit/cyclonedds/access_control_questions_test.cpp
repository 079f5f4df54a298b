// Questions of the other two libraries in the process to access control.

#include "plugins/cyclonedds/access_control_adapter.hpp"
#include "plugins/cyclonedds/access_control_gate.hpp"
#include "tests/support/code_of.hpp"
#include "tests/unit/cyclonedds/access_control_adapters.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds::access_control_adapters {
namespace {

using test::code_of;
using testing::_;
using testing::Return;

using Handle = spi::PermissionsHandle;

// Our authentication, which is in another library, asks this.
TEST_F(AccessControlAdapterTest, OtherLibrary_IsToldWhatTheGovernanceAllows) {
  constexpr spi::IdentityHandle kOpen{1}, kClosed{2};
  ON_CALL(plugin, validate_local_permissions(kOpen, _, _, _)).WillByDefault(Return(Handle{8}));
  ON_CALL(plugin, validate_local_permissions(kClosed, _, _, _)).WillByDefault(Return(Handle{9}));
  ON_CALL(plugin, participant_sec_attributes).WillByDefault([](Handle handle) {
    return spi::ParticipantSecurityAttributes{.allow_unauthenticated_participants =
                                                  handle == Handle{8}};
  });
  for (const auto local : {kOpen, kClosed})
    EXPECT_NE(c->validate_local_permissions(c, nullptr, local.value, 5, &qos, nullptr), 0);
  const auto facts = &AccessControlAdapter::governance_facts_of;
  EXPECT_TRUE(has(facts(kOpen), GovernanceFact::allows_unauthenticated));
  EXPECT_FALSE(has(facts(kClosed), GovernanceFact::allows_unauthenticated));
  EXPECT_EQ(c->return_permissions_handle(c, 8, nullptr), 1);
  EXPECT_EQ(facts(kOpen), 0u);
}

TEST_F(AccessControlAdapterTest, EachRenewal_IsReportedOnce) {
  constexpr spi::IdentityHandle kLocal{1}, kOther{2};
  ON_CALL(plugin, validate_local_permissions).WillByDefault(Return(Handle{8}));
  ON_CALL(plugin, permissions_credential_token(Handle{8}))
      .WillByDefault(Return(spi::Token{.class_id = "c", .properties = {{"dds.perm.cert", "new"}}}));
  EXPECT_NE(c->validate_local_permissions(c, nullptr, kLocal.value, 5, &qos, nullptr), 0);
  const auto renewed = &AccessControlAdapter::renewed_permissions;
  EXPECT_FALSE(renewed(kLocal, 0));
  ON_CALL(plugin, renewals(Handle{8})).WillByDefault(Return(2));
  EXPECT_FALSE(renewed(kOther, 0));
  const auto told = renewed(kLocal, 1);
  ASSERT_TRUE(told);
  EXPECT_EQ(told->times, 2u);
  EXPECT_EQ(told->text, "new");
  EXPECT_FALSE(renewed(kLocal, 2));
  EXPECT_EQ(c->return_permissions_handle(c, 8, nullptr), 1);
  EXPECT_FALSE(renewed(kLocal, 1));
}

// The core drops the permissions of a peer that cryptography refused to register.
TEST_F(AccessControlAdapterTest, PermissionsThatTheHostDropped_AreReturnedWithThePeer) {
  constexpr spi::IdentityHandle kPeer{41}, kOther{42};
  EXPECT_CALL(plugin, validate_remote_permissions)
      .WillOnce(Return(Handle{7}))
      .WillOnce(Return(Handle{8}))
      .WillOnce(Return(Handle{9}))
      .WillOnce(Return(Handle{10}));
  for (const auto peer : {kPeer, kPeer, kOther, kPeer})
    EXPECT_NE(c->validate_remote_permissions(c, nullptr, 1, peer.value, nullptr, &token, nullptr),
              0);
  std::vector<std::int64_t> returned;
  ON_CALL(plugin, return_permissions_handle).WillByDefault([&](Handle handle) -> Status {
    returned.push_back(handle.value);
    return {};
  });
  EXPECT_EQ(c->return_permissions_handle(c, 8, nullptr), 1);
  AccessControlAdapter::return_permissions_of(kPeer);
  EXPECT_EQ(returned, (std::vector<std::int64_t>{8, 7, 10}));
  AccessControlAdapter::return_permissions_of(kPeer);
  EXPECT_EQ(c->return_permissions_handle(c, 9, nullptr), 1);
  AccessControlAdapter::return_permissions_of(kOther);
  EXPECT_EQ(returned, (std::vector<std::int64_t>{8, 7, 10, 9}));
}

TEST_F(AccessControlAdapterTest, EachAdapter_IsAskedAboutItsOwnAndNoneThatIsGone) {
  std::uint64_t gone = 0;
  {
    Harness<AccessControlAdapter, MockAccessControl, spi::AccessControl> other;
    gone = other.adapter.id();
    EXPECT_NE(gone, harness.adapter.id());
    EXPECT_CALL(*other.plugin, check_remote_match(_, _));
    EXPECT_CALL(plugin, check_remote_match(_, _)).Times(0);
    EXPECT_TRUE(AccessControlGate(scope_of(gone), AccessControlAdapter::judge).check({}));
  }
  EXPECT_EQ(code_of(AccessControlGate(scope_of(gone), AccessControlAdapter::judge).check({})),
            Code::access_control_missing);
  auto broken = scope_of(harness.adapter.id());
  broken[0].value += "x";
  EXPECT_EQ(code_of(AccessControlGate(broken, AccessControlAdapter::judge).check({})),
            Code::access_control_missing);
  EXPECT_EQ(AccessControlAdapter::judge(nullptr), MatchVerdict::unknown_access_control);
  // No library of this process exports the function.
  EXPECT_EQ(code_of(AccessControlGate(scope_of(harness.adapter.id())).check({})),
            Code::access_control_missing);
}

}  // namespace
}  // namespace ddssec::cyclonedds::access_control_adapters
