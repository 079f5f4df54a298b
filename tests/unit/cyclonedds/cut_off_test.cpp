// A local participant whose certificate or permissions have ended. The host does not hear of it,
// because it would delete the participant beneath the application's entities. Our plugins refuse
// the participant instead.
#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#include "plugins/cyclonedds/access_control_adapter.hpp"
#include "plugins/cyclonedds/authentication_adapter.hpp"
#include "tests/unit/cyclonedds/revocation_listeners.hpp"
#include "tests/unit/cyclonedds/support.hpp"

static std::atomic<DDS_Security_IdentityHandle> cut_off_in_cryptography{0};
static std::atomic<DDS_Security_IdentityHandle> cut_off_in_access_control{0};
static std::atomic<DDS_Security_IdentityHandle> ended_in_access_control{0};

namespace ddssec::cyclonedds {
namespace {

constexpr spi::IdentityHandle kOwn{5}, kRemote{31};
std::atomic<int> told{0};

template <class F>
bool soon(F&& is_so) {
  for (int i = 0; i < 1000 && !is_so(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return is_so();
}

TEST(CutOffIdentity, OwnIdentityEnded_IsNotToldToTheHost) {
  Harness<AuthenticationAdapter, MockAuthentication, spi::Authentication> harness;
  auto* c = static_cast<dds_security_authentication*>(&harness.adapter);
  harness.adapter.remotes().note(kOwn, {{{0x81}}, kEntityIdParticipant}, kRemote);
  ON_CALL(*harness.plugin, poll).WillByDefault([](auto) { return std::vector{kOwn, kRemote}; });
  static std::atomic<DDS_Security_IdentityHandle> revoked{0};
  told = 0;
  cut_off_in_cryptography = cut_off_in_access_control = 0;
  const dds_security_authentication_listener listener{
      [](const dds_security_authentication*,
         const DDS_Security_IdentityHandle handle) -> DDS_Security_boolean {
        revoked = handle;
        ++told;
        return 1;
      },
      nullptr};
  ASSERT_EQ(c->set_listener(c, &listener, nullptr), 1);
  EXPECT_TRUE(soon([] { return told > 0; }));
  EXPECT_EQ(c->set_listener(c, nullptr, nullptr), 1);
  EXPECT_EQ(revoked, kRemote.value);
  EXPECT_EQ(cut_off_in_cryptography, kOwn.value) << "before any peer goes";
  EXPECT_EQ(cut_off_in_access_control, kOwn.value);
}

// When peers give up a participant that is still announced, the host applies their messages to all
// local participants.
TEST(CutOffIdentity, OwnIdentityEndedBesideOthersInTheDomain_IsToldToTheHost) {
  Harness<AuthenticationAdapter, MockAuthentication, spi::Authentication> harness;
  auto* c = static_cast<dds_security_authentication*>(&harness.adapter);
  harness.adapter.dispose_announcements().add_local(kOwn, {{1}});
  harness.adapter.dispose_announcements().add_local({6}, {{2}});
  ON_CALL(*harness.plugin, poll).WillByDefault([](auto) { return std::vector{kOwn}; });
  static std::atomic<DDS_Security_IdentityHandle> revoked{0};
  ASSERT_EQ(c->set_listener(c, &kNotesRevokedIdentity<revoked>, nullptr), 1);
  EXPECT_TRUE(soon([] { return revoked == kOwn.value; }));
  EXPECT_EQ(c->set_listener(c, nullptr, nullptr), 1);
}

// The other participant's permissions have ended, so it does not count as valid any more.
TEST(CutOffIdentity, OwnIdentityEndedAfterTheOthersWereCutOff_IsNotToldToTheHost) {
  Harness<AuthenticationAdapter, MockAuthentication, spi::Authentication> harness;
  auto* c = static_cast<dds_security_authentication*>(&harness.adapter);
  harness.adapter.dispose_announcements().add_local(kOwn, {{1}});
  harness.adapter.dispose_announcements().add_local({6}, {{2}});
  harness.adapter.remotes().note(kOwn, {{{0x81}}, kEntityIdParticipant}, kRemote);
  ended_in_access_control = 6;
  ON_CALL(*harness.plugin, poll).WillByDefault([](auto) { return std::vector{kOwn, kRemote}; });
  static std::atomic<bool> told_of_own{false};
  told = 0;
  const dds_security_authentication_listener listener{
      [](const dds_security_authentication*,
         const DDS_Security_IdentityHandle handle) -> DDS_Security_boolean {
        if (handle == kOwn.value) told_of_own = true;
        ++told;
        return 1;
      },
      nullptr};
  ASSERT_EQ(c->set_listener(c, &listener, nullptr), 1);
  EXPECT_TRUE(soon([] { return told > 0; }));
  EXPECT_EQ(c->set_listener(c, nullptr, nullptr), 1);
  EXPECT_FALSE(told_of_own);
  ended_in_access_control = 0;
}

struct CutOffPermissions : testing::Test {
  CutOffPermissions() {
    ON_CALL(plugin, validate_local_permissions).WillByDefault([](auto&&...) {
      return spi::PermissionsHandle{8};
    });
    EXPECT_EQ(c->validate_local_permissions(c, nullptr, kOwn.value, 5, &qos, nullptr), 8);
  }
  bool may_create() {
    const bool topic = c->check_create_topic(c, 8, 5, "Square", &qos, nullptr) != 0;
    const bool reader =
        c->check_create_datareader(c, 8, 5, "Square", &qos, nullptr, nullptr, nullptr) != 0;
    const bool writer =
        c->check_create_datawriter(c, 8, 5, "Square", &qos, nullptr, nullptr, nullptr) != 0;
    EXPECT_EQ(topic, reader);
    EXPECT_EQ(topic, writer);
    return topic;
  }

  Harness<AccessControlAdapter, MockAccessControl, spi::AccessControl> harness;
  dds_security_access_control* c = &harness.adapter;
  MockAccessControl& plugin = *harness.plugin;
  DDS_Security_Qos qos{};
};

TEST_F(CutOffPermissions, EveryCreation_IsRefusedWithTheReason) {
  EXPECT_TRUE(may_create());
  AccessControlAdapter::cut_off({6});
  EXPECT_TRUE(may_create()) << "that was another";
  AccessControlAdapter::cut_off(kOwn);
  EXPECT_FALSE(may_create());
  Refusal refusal;
  EXPECT_EQ(c->check_create_topic(c, 8, 5, "Square", &qos, &refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::identity_ended);
}

TEST_F(CutOffPermissions, OwnEnd_IsNotRevokedThroughTheListenerButThatOfPeersIs) {
  ON_CALL(plugin, poll).WillByDefault([](auto) {
    return std::vector<spi::PermissionsHandle>{{8}, {41}};
  });
  static std::atomic<DDS_Security_PermissionsHandle> revoked{0};
  cut_off_in_cryptography = 0;
  ASSERT_EQ(c->set_listener(c, &kNotesRevokedPermissions<revoked>, nullptr), 1);
  EXPECT_TRUE(soon([] { return revoked != 0; }));
  EXPECT_EQ(c->set_listener(c, nullptr, nullptr), 1);
  EXPECT_EQ(revoked, 41);
  EXPECT_EQ(cut_off_in_cryptography, kOwn.value);
  EXPECT_FALSE(may_create());
  Refusal refusal;
  EXPECT_EQ(c->check_create_topic(c, 8, 5, "Square", &qos, &refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::grant_expired);
}

TEST_F(CutOffPermissions, OwnEndBesideOthersInTheDomain_IsRevoked) {
  ON_CALL(plugin, validate_local_permissions).WillByDefault([](auto&&...) {
    return spi::PermissionsHandle{9};
  });
  EXPECT_EQ(c->validate_local_permissions(c, nullptr, 6, 5, &qos, nullptr), 9);
  ON_CALL(plugin, poll).WillByDefault([](auto) {
    return std::vector<spi::PermissionsHandle>{{8}};
  });
  static std::atomic<DDS_Security_PermissionsHandle> revoked{0};
  ASSERT_EQ(c->set_listener(c, &kNotesRevokedPermissions<revoked>, nullptr), 1);
  EXPECT_TRUE(soon([] { return revoked == 8; }));
  EXPECT_EQ(c->set_listener(c, nullptr, nullptr), 1);
}

// Two participants whose permissions end in one look, together with those of a peer. A third
// participant may stay valid.
struct CutOffTogether : CutOffPermissions {
  CutOffTogether() {
    ended().clear();
    add(9, 6);
    ON_CALL(plugin, poll).WillByDefault([](auto) {
      return std::vector<spi::PermissionsHandle>{{8}, {9}, {41}};
    });
  }
  void add(std::int64_t permissions, std::int64_t local) {
    ON_CALL(plugin, validate_local_permissions).WillByDefault([permissions](auto&&...) {
      return spi::PermissionsHandle{permissions};
    });
    EXPECT_EQ(c->validate_local_permissions(c, nullptr, local, 5, &qos, nullptr), permissions);
  }
  // Returns the handles that the host is told about in the first look.
  std::vector<std::int64_t> told_of() {
    const dds_security_access_control_listener listener{
        [](const dds_security_access_control*,
           const DDS_Security_PermissionsHandle handle) -> DDS_Security_boolean {
          ended().push_back(handle);
          if (handle == 41) told = 1;
          return 1;
        }};
    told = 0;
    EXPECT_EQ(c->set_listener(c, &listener, nullptr), 1);
    EXPECT_TRUE(soon([] { return told == 1; }));
    EXPECT_EQ(c->set_listener(c, nullptr, nullptr), 1);
    const auto first = std::ranges::find(ended(), 41);
    return {ended().begin(), first == ended().end() ? first : first + 1};
  }

 private:
  static std::vector<std::int64_t>& ended() {
    static std::vector<std::int64_t> handles;
    return handles;
  }
};

TEST_F(CutOffTogether, NoneIsLeft_TheHostIsToldOfThePeerOnly) {
  EXPECT_EQ(told_of(), (std::vector<std::int64_t>{41}));
  EXPECT_FALSE(may_create());
}

TEST_F(CutOffTogether, AThirdIsLeft_TheHostIsToldOfAll) {
  add(10, 7);
  EXPECT_EQ(told_of(), (std::vector<std::int64_t>{8, 9, 41}));
}

TEST_F(CutOffTogether, Authentication_HearsWhoIsCutOff) {
  EXPECT_FALSE(has(AccessControlAdapter::governance_facts_of(kOwn), GovernanceFact::cut_off));
  told_of();
  EXPECT_TRUE(has(AccessControlAdapter::governance_facts_of(kOwn), GovernanceFact::cut_off));
}

}  // namespace
}  // namespace ddssec::cyclonedds

// Our other plugins export these functions in the same process.
DDSSEC_EXPORT void ddssec_cut_off_cryptography(DDS_Security_IdentityHandle local) {
  cut_off_in_cryptography = local;
}
DDSSEC_EXPORT void ddssec_cut_off_access_control(DDS_Security_IdentityHandle local) {
  cut_off_in_access_control = local;
}
DDSSEC_EXPORT std::uint32_t ddssec_governance_facts_of(DDS_Security_IdentityHandle local) {
  if (local == 0 || local != ended_in_access_control) return 0;
  return static_cast<std::uint32_t>(ddssec::cyclonedds::GovernanceFact::cut_off);
}
