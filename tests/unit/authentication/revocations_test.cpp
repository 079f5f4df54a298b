// Revocation lists that arrive while identities are in use.
#include <thread>

#include <gmock/gmock.h>

#include "plugins/authentication/revocation_lists.hpp"
#include "tests/support/delta_list.hpp"
#include "tests/support/recorded_document.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/authentication/revocation_lists.hpp"

using testing::MatchesRegex;

namespace ddssec::authentication {
namespace {

// Alice has a file with a list. Bob has none.
class RunningRevocation : public testing::Test {
 protected:
  explicit RunningRevocation(const std::string& first = pem({}))
      : path_(folder_.write("crl.pem", first)),
        pairing_(with_list(alice(), "file:" + path_), bob()) {}

  // Alice looks at her list as often as a host does in a quarter of a minute.
  std::vector<IdentityHandle> wait() {
    std::vector<IdentityHandle> ended;
    for (int i = 0; i < 3; ++i) {
      plugin().clock.advance(5s);
      for (const auto handle : plugin()->poll()) ended.push_back(handle);
    }
    return ended;
  }
  std::vector<IdentityHandle> put(std::string_view text) {
    folder_.replace("crl.pem", text);
    return wait();
  }
  // Repeats the handshake of the two, from the first message to the end or the first refusal.
  Status handshake() {
    auto& two = pairing_.two;
    DDSSEC_RETURN_IF_ERROR(two.low.discover(two.high));
    DDSSEC_RETURN_IF_ERROR(two.high.discover(two.low));
    DDSSEC_ASSIGN_OR_RETURN(const auto request, two.request());
    DDSSEC_ASSIGN_OR_RETURN(const auto reply, two.reply(*request.message));
    DDSSEC_ASSIGN_OR_RETURN(const auto final,
                            two.process_at_lower_guid(request.handle, *reply.message));
    DDSSEC_RETURN_IF_ERROR(two.process_at_higher_guid(reply.handle, *final.message));
    return {};
  }
  TestPlugin& plugin() { return pairing_.first_plugin; }
  const std::vector<Event>& events() { return plugin().events.all; }
  std::vector<Code> codes() { return plugin().events.codes(); }
  IdentityHandle& bob_at_alice() {
    return &pairing_.two.low == &pairing_.a ? pairing_.two.high_at_low : pairing_.two.low_at_high;
  }
  // The host gives the handle back, and Bob is discovered again.
  void rediscover_bob() {
    ASSERT_OK(plugin()->return_identity_handle(bob_at_alice()));
    const auto again = pairing_.a.discover(pairing_.b);
    ASSERT_OK(again);
    bob_at_alice() = again->handle;
  }

  const test::TemporaryFolder folder_;
  const std::string path_;
  Pairing pairing_;
};

TEST_F(RunningRevocation, ARevokedPeer_IsEndedAndDoesNotComeBack) {
  pairing_.expect_success();
  EXPECT_TRUE(wait().empty());
  EXPECT_EQ(put(pem({2, {bob().certificate}})), std::vector{bob_at_alice()});
  ASSERT_EQ(codes(), (std::vector{Code::crl_renewed, Code::certificate_revoked}));
  EXPECT_THAT(events()[0].error.details().found,
              MatchesRegex("number 2 of 2026-11-20T23:00:00Z by CN=Identity CA,O=Example"
                           " \\(key [0-9a-f]{8}\\)"));
  const auto& event = events()[1];
  EXPECT_EQ(event.peer_subject, "CN=bob,O=Example");
  EXPECT_EQ(event.guid, pairing_.b.guid.to_string());
  EXPECT_EQ(event.error.details().document, path_);
  EXPECT_EQ(event.error.details().field, "CN=bob,O=Example");
  EXPECT_NE(event.error.to_sentence().find(bob().certificate.serial()), std::string::npos);

  EXPECT_TRUE(wait().empty()) << "ended twice";
  EXPECT_CODE(pairing_.a.discover(pairing_.b), certificate_revoked);
  rediscover_bob();
  EXPECT_CODE(handshake(), certificate_revoked);
}

TEST_F(RunningRevocation, PeerNotOnTheList_Stays) {
  pairing_.expect_success();
  EXPECT_TRUE(put(pem({2, {alice().certificate, bob().certificate}}, make_ca("CN=X"))).empty());
  EXPECT_TRUE(put(pem({3, {make_identity(test_ca(), "CN=carol").certificate}})).empty());
  EXPECT_TRUE(handshake());
}

// A certificate that was judged before is judged again by the new list.
TEST_F(RunningRevocation, AHandshakeUnderWay_IsJudgedByTheNewList) {
  auto& two = pairing_.two;
  const auto request = two.request();
  ASSERT_OK(request);
  const auto reply = two.reply(*request->message);
  ASSERT_OK(reply);
  EXPECT_TRUE(put(pem({2, {bob().certificate}})).empty());
  const auto final = two.process_at_lower_guid(request->handle, *reply->message);
  if (&two.low == &pairing_.a) {
    EXPECT_CODE(final, certificate_revoked);
  } else {
    ASSERT_OK(final);
    EXPECT_CODE(two.process_at_higher_guid(reply->handle, *final->message), certificate_revoked);
  }
}

TEST_F(RunningRevocation, OurOwnRevocation_EndsUsAndOurPeers) {
  pairing_.expect_success();
  EXPECT_EQ(put(pem({2, {alice().certificate}})), (std::vector{pairing_.a.handle, bob_at_alice()}));
  EXPECT_EQ(events().back().error.code(), Code::certificate_revoked);
  EXPECT_EQ(events().back().peer_subject, "");
  EXPECT_EQ(events().back().guid, pairing_.a.guid.to_string());
  EXPECT_CODE(pairing_.a.discover(pairing_.b), certificate_revoked);
  EXPECT_CODE(plugin()->identity_token(pairing_.a.handle), certificate_revoked);
  EXPECT_TRUE(wait().empty());
}

// Each participant is judged by its own list, and each gets an event of its own.
TEST_F(RunningRevocation, TwoParticipantsOfOnePlugin_GoByTheirOwnLists) {
  Participant second(plugin(), make_identity(test_ca(), "CN=second"), 7);
  Two other(second, pairing_.b);
  pairing_.expect_success();
  const auto request = other.request();
  const auto reply = other.reply(*request->message);
  const auto final = other.process_at_lower_guid(request->handle, *reply->message);
  ASSERT_OK(other.process_at_higher_guid(reply->handle, *final->message));
  folder_.replace("crl.pem", pem({2, {bob().certificate}}));
  plugin().clock.advance(5s);
  EXPECT_TRUE(plugin()->poll(second.handle).empty());
  EXPECT_EQ(plugin()->poll(pairing_.a.handle), std::vector{bob_at_alice()});
  EXPECT_TRUE(wait().empty());
  EXPECT_TRUE(second.discover(pairing_.b));
}

// ---- files that may not bring a revoked peer back

class RefusedRevocationList : public RunningRevocation {
 protected:
  RefusedRevocationList() : RunningRevocation(pem({5, {bob().certificate}})) {}
  // Expects one event, however often the file is looked at. Bob stays out.
  void expect_refused(std::string_view text, Code code) {
    put(text);
    expect_refused(code);
  }
  void expect_older(std::string_view text) {
    put(text);
    EXPECT_EQ(codes(), std::vector{Code::crl_older});
    plugin().events.all.clear();
  }
  void expect_refused(Code code) {
    wait();
    ASSERT_EQ(codes(), std::vector{code}) << events().size();
    EXPECT_EQ(events()[0].error.details().document, path_);
    EXPECT_NE(events()[0].error.details().note.find("stay in force"), std::string::npos);
    EXPECT_EQ(events()[0].guid, pairing_.a.guid.to_string());
    EXPECT_CODE(handshake(), certificate_revoked);
    plugin().events.all.clear();
  }
};

TEST_F(RefusedRevocationList, LowerNumbersAndEarlierTimes_AreRefused) {
  expect_refused(pem({4}), Code::crl_older);
  expect_refused(pem({6, {}, kNow - 2h}), Code::crl_older);
  expect_refused(pem({5, {}, kNow - 2h}), Code::crl_older);
}

TEST_F(RefusedRevocationList, ForgedLists_AreRefused) {
  const auto twin = make_ca();
  expect_refused(pem({6}, twin), Code::crl_signature_invalid);
  expect_refused(pem({6}) + pem({7}, twin), Code::crl_signature_invalid);
  expect_refused(pem({6}, make_ca("CN=Other CA")), Code::crl_missing);
}

TEST_F(RefusedRevocationList, DeltaLists_AreRefused) {
  const auto newer = pki::Crl::all_from(as_bytes(pem({6})))->front();
  const auto delta = test::delta_pem(newer, test_ca(), 5);
  expect_refused(delta, Code::crl_is_delta);
  expect_refused(pem({5, {bob().certificate}}) + delta, Code::crl_is_delta);
}

TEST_F(RefusedRevocationList, ListsOutOfTheirTime_AreRefused) {
  expect_refused(pem({6, {}, kNow - 30min, kNow - 1s}), Code::crl_expired);
  expect_refused(pem({6, {}, kNow + 1h}), Code::crl_not_yet_valid);
}

// The list becomes valid although its file does not change.
TEST_F(RefusedRevocationList, AListOfTheFuture_IsTakenWhenItsTimeHasCome) {
  const auto recorded = [&] {
    return test::recorded_document(plugin().documents, "revocation list")["refused"];
  };
  expect_refused(pem({4}), Code::crl_older);
  EXPECT_EQ(recorded()["waits"], false);
  expect_refused(pem({6, {}, kNow + 1h}), Code::crl_not_yet_valid);
  EXPECT_EQ(recorded()["stands"], true);
  EXPECT_EQ(recorded()["waits"], true);
  plugin().clock.advance(1h);
  wait();
  EXPECT_EQ(codes(), std::vector{Code::crl_renewed});
  EXPECT_EQ(recorded()["stands"], false);
  EXPECT_TRUE(handshake());
}

// All clocks were ahead and were set back. The revoked peer stays revoked.
TEST_F(RefusedRevocationList, ListOfToday_ReplacesOneOfTheFutureIfItNamesAll) {
  plugin().clock.set(kNow + 200 * 24h);
  put(pem({6, {bob().certificate}, kNow + 200 * 24h}));
  EXPECT_EQ(codes(), std::vector{Code::crl_renewed});
  plugin().events.all.clear();
  plugin().clock.set(kNow);
  expect_older(pem({7}));
  expect_older(pem({6, {bob().certificate}}));
  put(pem({7, {bob().certificate}}));
  EXPECT_EQ(codes(), std::vector{Code::crl_renewed});
  EXPECT_CODE(handshake(), certificate_revoked);
}

TEST_F(RefusedRevocationList, OtherContent_IsRefused) {
  expect_refused("", Code::item_empty);
  expect_refused("nothing", Code::crl_file_empty);
  expect_refused(test_ca().certificate().pem(), Code::crl_file_empty);
  expect_refused("-----BEGIN X509 CRL-----\nAAAA\n-----END X509 CRL-----\n", Code::crl_malformed);
  std::filesystem::remove(path_);
  wait();
  expect_refused(Code::file_not_found);
  std::filesystem::create_directory(path_);
  wait();
  expect_refused(Code::file_unreadable);
}

TEST_F(RefusedRevocationList, ListCutOffAnywhere_IsRefused) {
  const auto whole = pem({6});
  for (std::size_t size = 0; size < whole.size() - 2; ++size) {
    folder_.replace("crl.pem", whole.substr(0, size));
    EXPECT_TRUE(wait().empty());
    EXPECT_EQ(std::ranges::count(codes(), Code::crl_renewed), 0) << size;
    plugin().events.all.clear();
  }
  EXPECT_CODE(handshake(), certificate_revoked);
  plugin().events.all.clear();
  put(whole);
  EXPECT_EQ(codes(), std::vector{Code::crl_renewed});
}

TEST_F(RefusedRevocationList, ListWithAnyBitChanged_IsRefused) {
  const auto whole = pem({6});
  for (std::size_t at = 0; at < whole.size(); at += 7) {
    auto changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ 2);
    put(changed);
    EXPECT_EQ(std::ranges::count(codes(), Code::crl_renewed), 0) << at;
    plugin().events.all.clear();
  }
  EXPECT_CODE(handshake(), certificate_revoked);
}

// One look finds half of the file, the next one all of it. No event reports the half.
TEST_F(RunningRevocation, AFileThatIsJustBeingWritten_IsNoReasonToComplain) {
  const auto whole = pem({2, {bob().certificate}});
  pairing_.expect_success();
  wait();
  folder_.write("crl.pem", whole.substr(0, whole.size() / 2));
  plugin().clock.advance(5s);
  EXPECT_TRUE(plugin()->poll().empty());
  folder_.write("crl.pem", whole);
  plugin().clock.advance(5s);
  EXPECT_EQ(plugin()->poll(), std::vector{bob_at_alice()});
  EXPECT_EQ(codes(), (std::vector{Code::crl_renewed, Code::certificate_revoked}));
}

// ---- authorities

struct Authorities {
  pki::Authority root = make_ca("CN=Root");
  pki::Authority sub = root.subordinate("CN=Sub", {}, kYear, test_random()).value();
  std::string bundle = "data:," + root.certificate().pem() + sub.certificate().pem();
  Identity of(const pki::Authority& ca, const std::string& name, int key) const {
    auto identity = make_identity(ca, name, {}, kYear, key);
    set(identity.properties, property::kIdentityCa, bundle);
    return identity;
  }
};

TEST(RevokedAuthority, RevokedCa_EndsThePeersItIssued) {
  const Authorities cas;
  const test::TemporaryFolder folder;
  const auto path = folder.write("crl.pem", pem({}, cas.root) + pem({}, cas.sub));
  Pairing pairing(with_list(cas.of(cas.root, "CN=alice", 0), "file:" + path),
                  cas.of(cas.sub, "CN=bob", 1));
  pairing.expect_success();
  auto& plugin = pairing.first_plugin;
  const auto poll = [&] {
    plugin.clock.advance(5s);
    return plugin->poll();
  };
  folder.replace("crl.pem", pem({2, {cas.sub.certificate()}}, cas.root) + pem({}, cas.sub));
  EXPECT_EQ(poll().size(), 1u);
  ASSERT_EQ(plugin.events.all.size(), 2u);
  const auto& event = plugin.events.all[1];
  EXPECT_EQ(event.error.code(), Code::certificate_revoked);
  EXPECT_EQ(event.error.details().field, "CN=Sub");
  EXPECT_EQ(event.peer_subject, "CN=bob");
}

// An attacker who removes a list would hide a revocation.
TEST(RevokedAuthority, TwoCasOfOneName_EachKeepsItsList) {
  const auto old = make_ca("CN=Plant"), now = make_ca("CN=Plant");
  const std::vector anchors{old.certificate(), now.certificate()};
  const auto lists = [&](const std::string& text) { return *pki::Crl::all_from(as_bytes(text)); };
  const auto held = lists(pem({2}, old) + pem({1}, now));
  EXPECT_TRUE(check_renewal(lists(pem({2}, old) + pem({2}, now)), held, anchors, kNow));
  EXPECT_CODE(check_renewal(lists(pem({9}, now)), held, anchors, kNow), crl_missing);
  EXPECT_CODE(check_renewal(lists(pem({1}, old) + pem({9}, now)), held, anchors, kNow), crl_older);
}

TEST(RevokedAuthority, ListOfEachCa_MustStay) {
  const Authorities cas;
  const test::TemporaryFolder folder;
  const auto path = folder.write("crl.pem", pem({}, cas.root) + pem({}, cas.sub));
  TestPlugin plugin;
  Participant alice(plugin, with_list(cas.of(cas.root, "CN=alice", 0), "file:" + path));
  folder.replace("crl.pem", pem({2}, cas.root));
  for (int i = 0; i < 3; ++i) {
    plugin.clock.advance(5s);
    EXPECT_TRUE(plugin->poll().empty());
  }
  ASSERT_EQ(plugin.events.all.size(), 1u);
  EXPECT_EQ(plugin.events.all[0].error.code(), Code::crl_missing);
}

// ---- many

TEST(ManyRevoked, ManyRevokedPeers_EndAtOnce) {
  constexpr int kPeers = 100;
  const test::TemporaryFolder folder;
  const auto path = folder.write("crl.pem", pem({}));
  TestPlugin ours(1), theirs(2);
  Participant us(ours, with_list(alice(), "file:" + path));
  List list{2};
  for (int i = 0; i < kPeers; ++i) {
    const auto identity = make_identity(test_ca(), "CN=peer" + std::to_string(i), {}, kYear, 1);
    if (i % 2 == 0) list.revoked.push_back(identity.certificate);
    Participant peer(theirs, identity, static_cast<std::uint8_t>(i + 2));
    Two two(us, peer);
    const auto request = two.request();
    const auto reply = two.reply(*request->message);
    const auto final = two.process_at_lower_guid(request->handle, *reply->message);
    ASSERT_OK(two.process_at_higher_guid(reply->handle, *final->message));
  }
  folder.replace("crl.pem", pem(list));
  ours.clock.advance(5s);
  EXPECT_EQ(ours->poll().size(), kPeers / 2u);
}

// Lists arrive while other threads shake hands. Each peer that is revoked at the end is out.
TEST(ManyRevoked, RevocationDuringHandshakes_EndsEveryRevokedPeer) {
  const test::TemporaryFolder folder;
  const auto path = folder.write("crl.pem", pem({}));
  for (int round = 0; round < 20; ++round) {
    const bool revokes = round > 0;  // without a revocation the handshake succeeds
    folder.replace("crl.pem", pem({}));
    auto first = with_list(alice(), "file:" + path);
    set(first.properties, property::kFilesPollInterval, "1");
    Pairing pairing(first, bob());
    auto& two = pairing.two;
    if (revokes) folder.replace("crl.pem", pem({2, {bob().certificate}}));
    bool is_in = false;
    std::thread hands([&] {
      const auto request = two.request();
      const auto reply = two.reply(*request->message);
      if (!reply) return;
      const auto final = two.process_at_lower_guid(request->handle, *reply->message);
      is_in = final && two.process_at_higher_guid(reply->handle, *final->message);
    });
    const auto ended = pairing.first_plugin->poll();
    hands.join();
    if (revokes)
      EXPECT_TRUE(!is_in || !ended.empty());
    else
      EXPECT_TRUE(is_in && ended.empty());
  }
}

}  // namespace
}  // namespace ddssec::authentication
