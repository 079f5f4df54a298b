// Key revision: a participant that gets the revised keys reads on, and one that only has the former
// keys does not.
#include "plugins/cryptography/key_revision.hpp"

#include <atomic>
#include <thread>

#include <gtest/gtest.h>

#include "plugins/spi/named_key_revision.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kSign = ProtectionKind::sign;
constexpr auto kNone = ProtectionKind::none;
constexpr auto kSignOrigin = ProtectionKind::sign_with_origin_authentication;
constexpr auto kEncryptOrigin = ProtectionKind::encrypt_with_origin_authentication;

ProtectionKind payload_kind(ProtectionKind kind) { return is_encrypted(kind) ? kEncrypt : kSign; }

// Two participants with one kind of protection. `a` revises its keys, and `b` is told or not.
struct Revising {
  explicit Revising(ProtectionKind kind = kEncrypt)
      : two(participant_attributes(kind, true)),
        e(two.endpoints(endpoint_attributes(kind, payload_kind(kind)))) {}

  spi::CryptoKeyFactory& factory() { return two.a.factory(); }
  KeyRevision begin() { return factory().revise_local_entity_keys(two.a.participant).value(); }
  Status activate(KeyRevision revision) {
    return factory().activate_key_revision(two.a.participant, revision);
  }
  Tokens of_participant(KeyStage stage = KeyStage::revised) {
    return two.participant_tokens(stage).value();
  }
  Tokens of_writer(KeyStage stage = KeyStage::revised) {
    return two.writer_tokens(e, stage).value();
  }
  Status tell_participant(const Tokens& tokens) { return two.take_participant(tokens); }
  Status tell_reader(const Tokens& tokens) { return two.take_writer(e, tokens); }
  void tell() {
    ASSERT_TRUE(tell_participant(of_participant()));
    ASSERT_TRUE(tell_reader(of_writer()));
  }
  void revise() {
    const auto revision = begin();
    tell();
    ASSERT_TRUE(activate(revision));
  }

  // Messages of `a` at each level.
  struct Sent {
    Bytes message, submessage, payload;
  };
  Sent send() {
    const auto submessage = data_submessage(32);
    return {encode_message(two, rtps_message({submessage})).value(),
            encode_submessage(two, e, submessage).value(),
            encode_payload(two, e, Bytes(16, 0x5a)).value()};
  }
  // Returns the codes with which `b` answers each of them.
  std::array<Code, 3> receive(const Sent& sent) {
    return {code_of(decode_message(two, sent.message)),
            code_of(decode_submessage(two, e, sent.submessage)),
            code_of(decode_payload(two, e, sent.payload))};
  }
  static std::array<Code, 3> all(Code code) { return {code, code, code}; }

  TwoSides two;
  WriterToReader e;
};

constexpr auto kGood = Code{0};

KeyMaterial material_of(const spi::Token& token) { return read_crypto_token(token).value(); }

// Returns the same tokens with another revision.
Tokens renumbered(Tokens tokens, KeyRevision revision) {
  for (auto& token : tokens) {
    auto& octets = token.binary_properties.front().value;
    const auto kind = with_revision(TransformKind::from(BytesView(octets).first(4)), revision);
    std::ranges::copy(kind.octets, octets.begin());
  }
  return tokens;
}

// ---- numbers

TEST(KeyRevisionNumber, EachKind_HoldsItInItsFirstThreeOctets) {
  const TransformKind kind{{0x01, 0x02, 0x03, 4}};
  EXPECT_EQ(revision_of(kind), 0x010203u);
  EXPECT_EQ(with_revision(kAes256Gcm, 0xfedcba), (TransformKind{{0xfe, 0xdc, 0xba, 4}}));
  EXPECT_EQ(with_revision(kind, 0), kAes256Gcm);
}

TEST(KeyRevisionNumber, GreatestNumber_IsFollowedByOne) {
  EXPECT_EQ(next_revision(0), 1u);
  EXPECT_EQ(next_revision(0xfffffe), 0xffffffu);
  EXPECT_EQ(next_revision(0xffffff), 1u);
}

TEST(KeyRevisionNumber, HalfTheWayRound_DecidesWhichIsLater) {
  struct Row {
    KeyRevision revision, than;
    bool later;
  };
  for (const auto& [revision, than, later] :
       {Row{1, 0, true}, Row{0xffffff, 0, true}, Row{0, 1, false}, Row{0, 0, false},
        Row{0, 0xffffff, false}, Row{2, 1, true}, Row{1, 2, false}, Row{5, 5, false},
        Row{1, 0xffffff, true}, Row{0xffffff, 1, false}, Row{0x800000, 1, true},
        Row{0x800001, 1, false}})
    EXPECT_EQ(is_later(revision, than), later) << revision << " " << than;
}

// ---- what is sent

class RevisedKeys : public ::testing::TestWithParam<ProtectionKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, RevisedKeys,
                         ::testing::Values(kSign, kEncrypt, kSignOrigin, kEncryptOrigin));

TEST_P(RevisedKeys, ReceiverGivenThem_ReadsThem) {
  Revising r(GetParam());
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(r.receive(r.send()), Revising::all(kGood));
    r.revise();
  }
  EXPECT_EQ(r.receive(r.send()), Revising::all(kGood));
}

TEST_P(RevisedKeys, ReceiverWithTheFormerOnes_DoesNotReadThem) {
  Revising r(GetParam());
  EXPECT_EQ(r.receive(r.send()), Revising::all(kGood));
  ASSERT_TRUE(r.activate(r.begin()));
  const auto sent = r.send();
  EXPECT_EQ(r.receive(sent), Revising::all(Code::key_revision_unknown));
  // Giving them the number of the former keys does not help, because the key itself is another.
  auto renamed = sent;
  renamed.message[26] = renamed.submessage[6] = renamed.payload[2] = 0;
  EXPECT_EQ(r.receive(renamed), Revising::all(Code::tag_mismatch));
}

TEST_P(RevisedKeys, RevisedKey_KeepsIdAlgorithmAndReceiverKeyOnly) {
  Revising r(GetParam());
  const auto before = r.of_participant(KeyStage::in_use);
  const auto writer_before = r.of_writer(KeyStage::in_use);
  EXPECT_EQ(r.begin(), 1u);
  const auto check = [](const spi::Token& first, const spi::Token& second) {
    const auto former = material_of(first), next = material_of(second);
    EXPECT_EQ(next.kind, with_revision(former.kind, 1));
    EXPECT_EQ(next.sender_key_id, former.sender_key_id);
    EXPECT_EQ(next.receiver_key_id, former.receiver_key_id);
    EXPECT_TRUE(next.receiver_key == former.receiver_key);
    EXPECT_FALSE(next.sender_key == former.sender_key);
    EXPECT_FALSE(next.salt == former.salt);
  };
  check(before.front(), r.of_participant().front());
  const auto writer_after = r.of_writer();
  ASSERT_EQ(writer_after.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) check(writer_before[i], writer_after[i]);
}

TEST(KeyRevisionSteps, EachRevision_IsNamedByTokensMessagesAndSubmessages) {
  Revising test;
  for (const KeyRevision expected : {0u, 1u, 2u}) {
    if (expected != 0) test.revise();
    const auto sent = test.send();
    const auto& exchange = test.two.b.exchange();
    EXPECT_EQ(exchange.key_revision_of(test.of_participant(KeyStage::in_use)), expected);
    EXPECT_EQ(exchange.key_revision_of(test.of_writer(KeyStage::in_use)), expected);
    EXPECT_EQ(spi::named_key_revision(BytesView(sent.message).subspan(20)), expected);
    EXPECT_EQ(spi::named_key_revision(sent.submessage), expected);
  }
  EXPECT_EQ(spi::named_key_revision(Bytes(6)), 0u);
}

TEST(KeyRevisionSteps, BeforeActivation_ChangesNothing) {
  Revising r;
  const auto in_use = r.of_participant(KeyStage::in_use);
  const auto revision = r.begin();
  EXPECT_EQ(r.send().payload[2], 0);
  EXPECT_EQ(material_of(r.of_participant(KeyStage::in_use).front()), material_of(in_use.front()));
  ASSERT_TRUE(r.activate(revision));
  EXPECT_EQ(r.send().payload[2], 1);
  EXPECT_TRUE(r.of_participant().empty()) << "no revision is under way";
  EXPECT_EQ(material_of(r.of_participant(KeyStage::in_use).front()).kind,
            with_revision(kAes256Gcm, 1));
}

TEST(KeyRevisionSteps, KeyExchange_IsLeftAlone) {
  Revising r;
  const auto volatiles = r.two.volatile_endpoints();
  ASSERT_TRUE(r.activate(r.begin()));
  const auto sent = encode_submessage(r.two, volatiles, data_submessage(32, 0x07)).value();
  EXPECT_EQ(sent[6], 0);
  EXPECT_TRUE(decode_submessage(r.two, volatiles, sent));
}

TEST(KeyRevisionSteps, ReadersRevision_IsForItsWriters) {
  Revising r(kEncryptOrigin);
  auto& b = r.two.b;
  const auto revision = b.factory().revise_local_entity_keys(b.participant).value();
  const auto tokens =
      b.exchange()
          .create_local_datareader_crypto_tokens(r.e.reader, r.e.remote_writer, KeyStage::revised)
          .value();
  ASSERT_TRUE(r.two.take_reader(r.e, tokens));
  ASSERT_TRUE(b.factory().activate_key_revision(b.participant, revision));
  const auto reply = encode_reply(r.two, r.e, data_submessage(8, 0x06)).value();
  EXPECT_EQ(reply[6], 1);
  EXPECT_TRUE(decode_reply(r.two, r.e, reply));
}

TEST(KeyRevisionSteps, EndpointMadeMeanwhile_NeedsNone) {
  Revising r;
  const auto revision = r.begin();
  auto late = r.two.endpoints(endpoint_attributes(kEncrypt, kEncrypt));
  EXPECT_TRUE(r.two.writer_tokens(late, KeyStage::revised)->empty());
  ASSERT_TRUE(r.activate(revision));
  EXPECT_TRUE(decode_payload(r.two, late, encode_payload(r.two, late, Bytes(8)).value()));
  // The new endpoint takes part in the next revision, too.
  ASSERT_TRUE(r.activate(r.begin()));
  EXPECT_EQ(encode_payload(r.two, late, Bytes(8)).value()[2], 1);
}

TEST(KeyRevisionSteps, EndpointUnregisteredMeanwhile_IsForgotten) {
  Revising r;
  const auto revision = r.begin();
  ASSERT_TRUE(r.factory().unregister_datawriter(r.e.writer));
  ASSERT_TRUE(r.activate(revision));
  r.begin();
  ASSERT_TRUE(r.factory().unregister_participant(r.two.a.participant));
}

TEST(KeyRevisionSteps, ParticipantWithoutMessageProtection_RevisesItsEndpoints) {
  TwoSides two(participant_attributes(kNone, true));
  const auto revision = two.a.factory().revise_local_entity_keys(two.a.participant);
  EXPECT_EQ(*revision, 1u);
  EXPECT_TRUE(two.participant_tokens(KeyStage::revised)->empty());
}

TEST(KeyRevisionSteps, GovernanceWithoutIt_RevisesNothing) {
  TwoSides two(participant_attributes(kEncrypt, false));
  EXPECT_EQ(two.a.factory().revise_local_entity_keys(two.a.participant).value(), 0u);
  EXPECT_EQ(code_of(two.a.factory().activate_key_revision(two.a.participant, 1)),
            Code::key_revision_out_of_turn);
}

TEST(KeyRevisionSteps, OutOfTurnSteps_AreRefused) {
  Revising r;
  const auto again = [&] {
    return code_of(r.factory().revise_local_entity_keys(r.two.a.participant));
  };
  EXPECT_EQ(code_of(r.activate(0)), Code::key_revision_out_of_turn);
  const auto revision = r.begin();
  EXPECT_EQ(again(), Code::key_revision_out_of_turn);
  EXPECT_EQ(code_of(r.activate(revision + 1)), Code::key_revision_out_of_turn);
  EXPECT_TRUE(r.activate(revision));
  EXPECT_EQ(code_of(r.activate(revision)), Code::key_revision_out_of_turn);
  EXPECT_EQ(code_of(r.factory().revise_local_entity_keys({})), Code::crypto_handle_nil);
  EXPECT_EQ(code_of(r.factory().activate_key_revision(r.two.a.remote, 1)),
            Code::crypto_handle_wrong_kind);
}

// ---- what is received

TEST_P(RevisedKeys, FormerKeys_CountForAWhile) {
  Revising r(GetParam());
  const auto former = r.send(), late = r.send();
  r.revise();
  EXPECT_EQ(r.receive(former), Revising::all(kGood));
  EXPECT_EQ(r.receive(r.send()), Revising::all(kGood));
  r.two.b.clock.advance(kFormerKeyLife - std::chrono::nanoseconds(1));
  EXPECT_EQ(r.receive(late), Revising::all(kGood));
  r.two.b.clock.advance(std::chrono::nanoseconds(1));
  EXPECT_EQ(r.receive(former), Revising::all(Code::key_revision_unknown)) << "a replay";
  EXPECT_EQ(r.receive(r.send()), Revising::all(kGood));
}

TEST(FormerKeys, KeysAfterTheirTime_AreWiped) {
  Revising r;
  const auto former = r.send();
  r.revise();
  r.two.b.factory().forget_former_keys();
  EXPECT_EQ(r.receive(former), Revising::all(kGood)) << "too early";
  r.two.b.clock.advance(kFormerKeyLife);
  r.two.b.factory().forget_former_keys();
  r.two.b.clock.advance(-kFormerKeyLife);
  EXPECT_EQ(r.receive(former), Revising::all(Code::key_revision_unknown));
  EXPECT_EQ(r.receive(r.send()), Revising::all(kGood));
}

TEST(FormerKeys, ManyRevisions_KeepFewFormerKeys) {
  Revising r;
  std::vector<Revising::Sent> sent = {r.send()};
  for (std::size_t i = 0; i <= kMaxFormerRevisions; ++i) {
    r.revise();
    sent.push_back(r.send());
  }
  EXPECT_EQ(r.receive(sent[0]), Revising::all(Code::key_revision_unknown));
  for (std::size_t i = 1; i < sent.size(); ++i)
    EXPECT_EQ(r.receive(sent[i]), Revising::all(kGood)) << i;
}

TEST(FormerKeys, AnotherKeyInTheirPlace_EndsThem) {
  Revising r;
  const auto former = r.send();
  auto other = Revising();
  ASSERT_TRUE(r.tell_participant(other.of_participant(KeyStage::in_use)));
  EXPECT_NE(r.receive(former)[0], kGood);
}

TEST(RevisedTokens, OlderRevision_IsRefusedAndChangesNothing) {
  Revising r;
  const auto first = r.of_participant(KeyStage::in_use);
  const auto first_of_writer = r.of_writer(KeyStage::in_use);
  r.revise();
  EXPECT_EQ(code_of(r.tell_participant(first)), Code::key_revision_stale);
  EXPECT_EQ(code_of(r.tell_reader(first_of_writer)), Code::key_revision_stale);
  EXPECT_EQ(r.receive(r.send()), Revising::all(kGood));
  // Repeating the same tokens does no harm.
  EXPECT_TRUE(r.tell_participant(r.of_participant(KeyStage::in_use)));
  EXPECT_TRUE(r.tell_reader(r.of_writer(KeyStage::in_use)));
  EXPECT_EQ(r.receive(r.send()), Revising::all(kGood));
}

TEST(RevisedTokens, LastNumber_IsFollowedByTheFirst) {
  Revising r;
  const auto first = r.of_participant(KeyStage::in_use);
  EXPECT_TRUE(r.tell_participant(renumbered(first, 0xffffff)));
  EXPECT_TRUE(r.tell_participant(renumbered(first, 1)));
  EXPECT_EQ(code_of(r.tell_participant(renumbered(first, 0xffffff))), Code::key_revision_stale);
  EXPECT_EQ(code_of(r.tell_participant(first)), Code::key_revision_stale);
}

TEST(RevisedTokens, GovernanceWithoutRevision_RefusesThem) {
  TwoSides two(participant_attributes(kEncrypt, false));
  const auto tokens = two.participant_tokens();
  const auto set = [&](const Tokens& given) { return code_of(two.take_participant(given)); };
  EXPECT_EQ(set(renumbered(*tokens, 1)), Code::key_revision_not_enabled);
  EXPECT_EQ(set(*tokens), kGood);
}

TEST(RevisedTokens, TokensCutShortAnywhere_ChangeNothing) {
  Revising r(kEncryptOrigin);
  r.begin();
  const auto whole = r.of_writer();
  const auto size = whole.front().binary_properties.front().value.size();
  // Without our addition at the end, the key is one of another product.
  auto standard = material_of(whole.front());
  standard.position.reset();
  const auto without_position = serialize_key_material(standard).size();
  for (std::size_t length = 0; length < size; ++length) {
    if (length == without_position) continue;
    auto cut = whole;
    cut.front().binary_properties.front().value.resize(length);
    EXPECT_NE(code_of(r.tell_reader(cut)), kGood) << length;
    ASSERT_EQ(r.receive(r.send())[1], kGood) << length;
  }
}

// Other threads send and receive while the keys change.
TEST(KeyRevisionSteps, OtherThreadsSending_LoseNothing) {
  Revising r(kEncryptOrigin);
  std::atomic<bool> done = false;
  std::atomic<int> lost = 0, sent = 0;
  std::thread sender([&] {
    for (; !done; ++sent)
      if (r.receive(r.send()) != Revising::all(kGood)) ++lost;
  });
  for (int i = 0; i < 100; ++i) {
    r.revise();
    const int before = sent;
    while (sent == before) std::this_thread::yield();
  }
  done = true;
  sender.join();
  EXPECT_EQ(lost, 0);
}

}  // namespace
}  // namespace ddssec::cryptography::testing
