#include "plugins/cyclonedds/remote_identities.hpp"

#include <gtest/gtest.h>

namespace ddssec::cyclonedds {
namespace {

using spi::IdentityHandle;
using Handles = std::vector<IdentityHandle>;

constexpr IdentityHandle kFirst{1}, kSecond{2};

Guid guid_of(std::uint8_t octet) {
  Guid guid;
  guid.prefix.octets.fill(octet);
  return guid;
}

// Both local participants met the remote: 11 is its handle for the first one, and 12 for the second
// one.
struct RemoteIdentitiesTest : testing::Test {
  void SetUp() override {
    ASSERT_EQ(remotes.note(kFirst, guid_of(7), {11}), IdentityHandle{11});
    ASSERT_EQ(remotes.note(kSecond, guid_of(7), {12}), IdentityHandle{11});
  }
  RemoteIdentities remotes;
};

TEST_F(RemoteIdentitiesTest, SeveralPairs_AreOneToTheHost) {
  EXPECT_EQ(remotes.pair(kFirst, {11}), IdentityHandle{11});
  EXPECT_EQ(remotes.pair(kSecond, {11}), IdentityHandle{12});
  EXPECT_EQ(remotes.note(kFirst, guid_of(8), {13}), IdentityHandle{13});
  EXPECT_EQ(remotes.note(kSecond, guid_of(7), {12}), IdentityHandle{11});  // it is seen again
}

TEST_F(RemoteIdentitiesTest, UnknownHandles_StayWhatTheyAre) {
  EXPECT_EQ(remotes.pair(kFirst, {99}), IdentityHandle{99});
  EXPECT_EQ(remotes.pair({3}, {11}), IdentityHandle{11}) << "the plugin knows whose that is";
  EXPECT_EQ(remotes.pair(kFirst, {12}), IdentityHandle{12}) << "never given to the host";
  EXPECT_EQ(remotes.take({99}), Handles{{99}});
}

TEST_F(RemoteIdentitiesTest, OneReturn_ReturnsAllPairsToThePlugin) {
  EXPECT_EQ(remotes.take({11}), (Handles{{11}, {12}}));
  EXPECT_EQ(remotes.take({11}), Handles{{11}}) << "unknown, for the plugin to say";
  EXPECT_EQ(remotes.pair(kSecond, {11}), IdentityHandle{11});
  EXPECT_EQ(remotes.note(kSecond, guid_of(7), {14}), IdentityHandle{14});
}

TEST_F(RemoteIdentitiesTest, LocalThatMetThemFirst_MayLeave) {
  EXPECT_EQ(remotes.take(kFirst), Handles{kFirst});
  EXPECT_EQ(remotes.pair(kSecond, {11}), IdentityHandle{12});
  EXPECT_EQ(remotes.note({3}, guid_of(7), {15}), IdentityHandle{11});
  EXPECT_EQ(remotes.take(kSecond), Handles{kSecond});
  EXPECT_EQ(remotes.take({3}), Handles{IdentityHandle{3}});
  EXPECT_TRUE(remotes.take({11}).empty()) << "known to the host, with nothing behind it";
  EXPECT_EQ(remotes.take({11}), Handles{{11}});
}

TEST_F(RemoteIdentitiesTest, RefusedRemotes_HaveAHandleForTheHostOnly) {
  EXPECT_EQ(remotes.note_refused(guid_of(7)), IdentityHandle{11}) << "the host has one already";
  const auto own = remotes.note_refused(guid_of(9));
  EXPECT_LT(own.value, 0);
  EXPECT_EQ(remotes.note_refused(guid_of(9)), own);
  EXPECT_EQ(remotes.pair(kFirst, own), own) << "for the plugin to refuse";
  EXPECT_EQ(remotes.note(kFirst, guid_of(9), {15}), own);
  EXPECT_EQ(remotes.pair(kFirst, own), IdentityHandle{15});
  EXPECT_EQ(remotes.take(own), Handles{{15}});
  EXPECT_NE(remotes.note_refused(guid_of(9)), own);
}

TEST_F(RemoteIdentitiesTest, EndedRemotes_AreRevokedOnce) {
  EXPECT_EQ(remotes.to_revoke(Handles{{11}, {12}}).remotes, Handles{{11}});
  EXPECT_EQ(remotes.to_revoke(Handles{{12}}).remotes, Handles{{11}});
  EXPECT_EQ(remotes.to_revoke({}).remotes, Handles{});
}

// The host would delete a local participant beneath the application's entities.
TEST_F(RemoteIdentitiesTest, OwnEndedIdentities_AreToldApart) {
  const auto ended = remotes.to_revoke(Handles{kFirst, {11}});
  EXPECT_EQ(ended.locals, Handles{kFirst});
  EXPECT_TRUE(remotes.has_ended(kFirst));
  EXPECT_FALSE(remotes.has_ended(kSecond));
  remotes.take(kFirst);
  EXPECT_FALSE(remotes.has_ended(kFirst));
}

TEST_F(RemoteIdentitiesTest, OneLocalEnds_StayForTheOther) {
  EXPECT_EQ(remotes.to_revoke(Handles{kFirst, {11}}).remotes, Handles{});
  // The host may not have removed the first participant yet.
  EXPECT_EQ(remotes.to_revoke(Handles{kSecond, {12}}).remotes, Handles{{11}});
}

TEST_F(RemoteIdentitiesTest, AllLocalsEndTogether_AreRevoked) {
  const auto ended = remotes.to_revoke(Handles{kFirst, {11}, kSecond, {12}});
  EXPECT_EQ(ended.remotes, Handles{{11}});
  EXPECT_EQ(ended.locals, (Handles{kFirst, kSecond}));
}

TEST_F(RemoteIdentitiesTest, OtherLocalWasReturned_AreRevoked) {
  remotes.take(kFirst);
  EXPECT_EQ(remotes.to_revoke(Handles{kSecond, {12}}).remotes, Handles{{11}});
}

}  // namespace
}  // namespace ddssec::cyclonedds
