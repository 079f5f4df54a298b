// Rights of the local participant that peers do not know, because its permissions were renewed
// after their sessions began.
#include <gmock/gmock.h>

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/access_control/access_control_fixture.hpp"

namespace ddssec::access_control {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// The talker's permissions are in a file.
class UnknownRights : public AccessControlTest {
 protected:
  void SetUp() override {
    governance_document = protected_governance();
    auto& rules = governance_document.domain_rules.front().topic_rules;
    rules.insert(rules.begin(), {.topic_expression = "open", .enable_read_access_control = false});
    rules.front().enable_write_access_control = false;
    auto documents = properties(signed_document(governance::to_xml(governance_document)), "");
    for (auto& one : documents)
      if (one.name == spi::property::kPermissions) one.value = "file:" + path_;
    const auto own = plugin->validate_local_permissions(kLocalIdentity, 0, documents);
    ASSERT_TRUE(own) << own.error().to_sentence();
    own_ = *own;
  }
  // Returns permissions of the talker to publish and subscribe `names` until that time from now.
  std::string document(std::vector<std::string> names, std::chrono::hours until) const {
    auto all = rule(true);
    all.publish = {topics(names)};
    all.subscribe = {topics(std::move(names))};
    auto out = grant(kTalker, {all});
    out.validity.not_after = kNow + until;
    return signed_permissions({out});
  }
  void renew(const std::string& text) {
    folder_.replace("permissions.p7s", text);
    EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewed));
  }
  // Makes a peer to which this document was presented.
  spi::PermissionsHandle peer_that_saw(const std::string& text, bool runs_ddssec = true) {
    const auto handle =
        remote(open_permissions(kListener),
               {.presented_permissions = sha256(as_bytes(text)), .peer_reads_lists = runs_ddssec});
    EXPECT_TRUE(handle);
    return handle.value_or(spi::PermissionsHandle{});
  }
  bool is_unknown(std::string_view topic, bool writes = true) {
    log.all.clear();
    const bool out = is_unknown(own_, topic, writes);
    EXPECT_THAT(log.codes(), IsEmpty());
    return out;
  }
  bool is_unknown(spi::PermissionsHandle local, std::string_view topic, bool writes = true) {
    const spi::AccessControl::OwnEndpoint asked[] = {{writes, {.topic_name = topic}}};
    return plugin->find_unknown_right(local, asked).has_value();
  }

  const std::string first_ = document({"t"}, 24h), wider_ = document({"t", "u"}, 72h);
  const test::TemporaryFolder folder_;
  const std::string path_ = folder_.write("permissions.p7s", first_);
  spi::PermissionsHandle own_{};
};

TEST_F(UnknownRights, RightOfTheRenewedPermissionsOnly_IsUnknownUntilASessionBeginsWithThem) {
  const auto before = peer_that_saw(first_);
  EXPECT_FALSE(is_unknown("u")) << "nothing was renewed";
  renew(wider_);
  EXPECT_FALSE(is_unknown("t"));
  EXPECT_TRUE(is_unknown("u"));
  peer_that_saw(first_);
  EXPECT_TRUE(is_unknown("u", false));
  ASSERT_TRUE(plugin->return_permissions_handle(before));
  EXPECT_FALSE(is_unknown("u"));
  peer_that_saw(wider_);
  EXPECT_FALSE(is_unknown("u"));
  peer_that_saw(first_);  // its handshake was under way
  EXPECT_TRUE(is_unknown("u"));
}

TEST_F(UnknownRights, RightThatWasLostMeanwhile_IsUnknownToPeersThatSawTheNarrowerPermissions) {
  const auto narrower = document({"u"}, 48h);
  renew(narrower);
  peer_that_saw(narrower);
  renew(wider_);
  EXPECT_FALSE(is_unknown("u"));
  EXPECT_TRUE(is_unknown("t"));
}

// The host keeps such a handle after an error, until the process ends.
TEST_F(UnknownRights, PeerThatStaysAfterTheEnd_DoesNotCountAgain) {
  peer_that_saw(first_);
  renew(wider_);
  EXPECT_TRUE(is_unknown("u"));
  EXPECT_FALSE(is_unknown("u"));
  renew(document({"t", "u"}, 96h));
  EXPECT_FALSE(is_unknown("u"));
  peer_that_saw(first_);
  EXPECT_TRUE(is_unknown("u"));
}

TEST_F(UnknownRights, SeveralEndpoints_TheFirstUnknownOneIsFound) {
  peer_that_saw(first_);
  renew(wider_);
  const spi::AccessControl::OwnEndpoint asked[] = {
      {true, {.topic_name = "t"}}, {false, {.topic_name = "u"}}, {true, {.topic_name = "u"}}};
  EXPECT_EQ(plugin->find_unknown_right(own_, asked), 1u);
}

TEST_F(UnknownRights, TopicWithoutAccessControl_NeedsNone) {
  peer_that_saw(first_);
  renew(wider_);
  EXPECT_FALSE(is_unknown("open"));
  EXPECT_FALSE(is_unknown("open", false));
}

// Such a peer would keep its side of the session, and ignore each new handshake.
TEST_F(UnknownRights, PeerOnOtherPlugins_DoesNotCount) {
  peer_that_saw(first_, false);
  renew(wider_);
  EXPECT_FALSE(is_unknown("u"));
}

TEST_F(UnknownRights, PeerOfAnotherParticipant_DoesNotCount) {
  peer_that_saw(first_);
  const auto other = plugin->validate_local_permissions(
      {kLocalIdentity.value + 1}, 0,
      properties(signed_document(governance::to_xml(governance_document)), first_));
  ASSERT_TRUE(other);
  renew(wider_);
  EXPECT_FALSE(is_unknown(*other, "u"));
}

// The peer's core would keep these keys, and use them instead of those of the next session.
TEST_F(UnknownRights, KeysOfAnEndpointThatThePeerRefuses_AreNotHandedOut) {
  const auto peer = peer_that_saw(first_), stock = peer_that_saw(first_, false);
  renew(wider_);
  const auto match = [](std::string_view topic, bool remote_writes) {
    return spi::AccessControl::Match{
        .remote_writes = remote_writes, .local = {.topic_name = topic}, .remote = {}};
  };
  log.all.clear();
  EXPECT_CODE(plugin->check_remote_match(peer, match("u", false)), publish_not_allowed);
  EXPECT_CODE(plugin->check_remote_match(peer, match("u", true)), subscribe_not_allowed);
  EXPECT_TRUE(log.all.empty()) << "nothing is wrong: own_rights_gained says what happens";
  EXPECT_TRUE(plugin->check_remote_match(peer, match("t", false)));
  EXPECT_TRUE(plugin->check_remote_match(stock, match("u", false)));
  EXPECT_TRUE(plugin->check_remote_match(peer_that_saw(wider_), match("u", false)));
}

TEST_F(UnknownRights, HandleThatIsNotOfALocalParticipant_HasNone) {
  const auto remote = peer_that_saw(first_);
  renew(wider_);
  EXPECT_FALSE(is_unknown(remote, "u"));
  EXPECT_FALSE(is_unknown({9999}, "u"));
}

}  // namespace
}  // namespace ddssec::access_control
