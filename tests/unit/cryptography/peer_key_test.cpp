// A reader's keys for the participants that write its topic. A message to one of them cannot be
// opened by another one, whatever destination an attacker puts before it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "plugins/cryptography/key_revision.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kSign = ProtectionKind::sign;
constexpr auto kNone = ProtectionKind::none;
constexpr auto kSignOrigin = ProtectionKind::sign_with_origin_authentication;
constexpr auto kEncryptOrigin = ProtectionKind::encrypt_with_origin_authentication;

Bytes acknack() { return data_submessage(24, 0x06); }

// The reader of `two.b` with a writer of `two.a` and one of a third participant.
struct TwoWriters {
  explicit TwoWriters(ProtectionKind kind)
      : two(participant_attributes(kNone, true)),
        attributes(endpoint_attributes(kind, kNone)),
        first(two.endpoints(attributes)) {
    auto& b = two.b;
    other.participant =
        other.factory()
            .register_local_participant({1}, {1}, {}, participant_attributes(kNone, true))
            .value();
    TwoSides::match(other, 5);
    other_at_reader =
        b.factory()
            .register_matched_remote_participant(b.participant, {8}, {8}, shared_secret(5))
            .value();
    second.reader = first.reader;
    second.writer =
        other.factory().register_local_datawriter(other.participant, {}, attributes).value();
    second.remote_writer = writer_of(other_at_reader, 5).value();
    second.remote_reader = other.factory()
                               .register_matched_remote_datareader(second.writer, other.remote,
                                                                   shared_secret(5), false)
                               .value();
    tell_second().value();
  }

  // Makes one more writer of that participant, as the reader knows it.
  Result<DatawriterCryptoHandle> writer_of(ParticipantCryptoHandle participant,
                                           std::uint8_t seed = 1) {
    return two.b.factory().register_matched_remote_datawriter(first.reader, participant,
                                                              shared_secret(seed));
  }
  Tokens tokens(DatawriterCryptoHandle writer, KeyStage stage = KeyStage::in_use) {
    return two.b.exchange()
        .create_local_datareader_crypto_tokens(first.reader, writer, stage)
        .value();
  }
  KeyMaterial material(DatawriterCryptoHandle writer, KeyStage stage = KeyStage::in_use) {
    return read_crypto_token(tokens(writer, stage).front()).value();
  }
  Status tell_second(KeyStage stage = KeyStage::in_use) {
    return other.exchange().set_remote_datareader_crypto_tokens(
        second.writer, second.remote_reader, tokens(second.remote_writer, stage));
  }
  Result<Bytes> reply_to(std::vector<DatawriterCryptoHandle> writers) {
    const auto plain = acknack();
    return into_bytes(
        plain.size() + spi::protection_overhead(writers.size()), [&](MutableBytes out) {
          return two.b.transform().encode_datareader_submessage(first.reader, writers, plain, out);
        });
  }
  Result<Bytes> read_at_second(BytesView reply) {
    return into_bytes(reply.size(), [&](MutableBytes out) {
      return other.transform().decode_datareader_submessage(second.writer, second.remote_reader,
                                                            reply, out);
    });
  }
  Code route_at_second(BytesView reply) {
    return code_of(
        other.transform().preprocess_secure_submessage(other.participant, other.remote, reply));
  }

  TwoSides two;
  Side other;
  EndpointSecurityAttributes attributes;
  WriterToReader first, second;  // `second.writer` is a writer of the participant `other`
  ParticipantCryptoHandle other_at_reader;
};

class PeerKeys : public ::testing::TestWithParam<ProtectionKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, PeerKeys, ::testing::Values(kSign, kEncrypt));

TEST_P(PeerKeys, WhatAReaderSaysToOneParticipant_OpensAtNoOther) {
  TwoWriters w(GetParam());
  const auto to_first = w.reply_to({w.first.remote_writer}).value();
  const auto to_second = w.reply_to({w.second.remote_writer}).value();
  EXPECT_EQ(decode_reply(w.two, w.first, to_first), acknack());
  EXPECT_EQ(w.read_at_second(to_second), acknack());
  EXPECT_EQ(w.route_at_second(to_second), Code{});
  // An attacker changed INFO_DST to redirect the message.
  EXPECT_EQ(w.route_at_second(to_first), Code::unknown_key_id);
  EXPECT_EQ(code_of(w.read_at_second(to_first)), Code::transform_key_id_mismatch);
  EXPECT_EQ(code_of(decode_reply(w.two, w.first, to_second)), Code::transform_key_id_mismatch);
}

TEST_P(PeerKeys, RedirectedUnderTheOtherKeysName_DoesNotOpenEither) {
  TwoWriters w(GetParam());
  auto reply = w.reply_to({w.first.remote_writer}).value();
  const auto id = w.material(w.second.remote_writer).sender_key_id;
  std::ranges::copy(id.octets, reply.begin() + 8);
  EXPECT_EQ(w.route_at_second(reply), Code{});
  EXPECT_EQ(code_of(w.read_at_second(reply)), Code::tag_mismatch);
}

TEST_P(PeerKeys, TwoPeers_ShareNoKey) {
  TwoWriters w(GetParam());
  const auto one = w.material(w.first.remote_writer), other = w.material(w.second.remote_writer);
  EXPECT_EQ(one.kind, other.kind);
  EXPECT_NE(one.sender_key_id, other.sender_key_id);
  EXPECT_FALSE(one.sender_key == other.sender_key);
  EXPECT_FALSE(one.salt == other.salt);
  EXPECT_FALSE(one.has_receiver_key());
}

TEST_P(PeerKeys, AllWritersOfAParticipant_HaveTheSame) {
  TwoWriters w(GetParam());
  const auto further = w.writer_of(w.two.b.remote).value();
  EXPECT_EQ(w.material(further), w.material(w.first.remote_writer));
  const auto reply = w.reply_to({further, w.first.remote_writer});
  EXPECT_EQ(decode_reply(w.two, w.first, reply.value()), acknack());
}

TEST_P(PeerKeys, WritersOfSeveralOrNoParticipants_HaveNone) {
  TwoWriters w(GetParam());
  EXPECT_EQ(code_of(w.reply_to({w.first.remote_writer, w.second.remote_writer})),
            Code::receiver_count);
  EXPECT_EQ(code_of(w.reply_to({})), Code::receiver_count);
  auto elsewhere = w.two.endpoints(w.attributes);
  EXPECT_EQ(code_of(w.reply_to({elsewhere.remote_writer})), Code::crypto_not_matched);
}

TEST_P(PeerKeys, WriterThatHasLeftMeanwhile_DoesNotMatter) {
  TwoWriters w(GetParam());
  const auto further = w.writer_of(w.two.b.remote).value();
  ASSERT_TRUE(w.two.b.factory().unregister_datawriter(further));
  const auto reply = w.reply_to({further, w.first.remote_writer});
  EXPECT_EQ(decode_reply(w.two, w.first, reply.value()), acknack());
  EXPECT_TRUE(w.reply_to({w.first.remote_writer, further}));
  EXPECT_EQ(code_of(w.reply_to({further})), Code::crypto_handle_unknown);
}

TEST_P(PeerKeys, LastWriterOfTheParticipant_EndsThem) {
  TwoWriters w(GetParam());
  auto& factory = w.two.b.factory();
  const auto before = w.material(w.first.remote_writer);
  const auto further = w.writer_of(w.two.b.remote).value();
  ASSERT_TRUE(factory.unregister_datawriter(w.first.remote_writer));
  EXPECT_EQ(w.material(further), before);
  ASSERT_TRUE(factory.unregister_datawriter(further));
  const auto after = w.material(w.writer_of(w.two.b.remote).value());
  EXPECT_NE(after.sender_key_id, before.sender_key_id);
  EXPECT_FALSE(after.sender_key == before.sender_key);
  EXPECT_EQ(w.read_at_second(w.reply_to({w.second.remote_writer}).value()), acknack());
}

TEST_P(PeerKeys, ParticipantThatLeaves_EndsItsKey) {
  TwoWriters w(GetParam());
  ASSERT_TRUE(w.two.b.factory().unregister_participant(w.two.b.remote));
  EXPECT_EQ(code_of(w.reply_to({w.first.remote_writer})), Code::crypto_handle_unknown);
  EXPECT_EQ(w.read_at_second(w.reply_to({w.second.remote_writer}).value()), acknack());
  ASSERT_TRUE(w.two.b.factory().unregister_datareader(w.first.reader));
  EXPECT_EQ(code_of(w.reply_to({w.second.remote_writer})), Code::crypto_handle_unknown);
}

TEST_P(PeerKeys, RevisingOne_LeavesTheOther) {
  TwoWriters w(GetParam());
  auto& b = w.two.b;
  const auto former = w.reply_to({w.second.remote_writer}).value();
  const auto revision = b.factory().revise_local_entity_keys(b.participant).value();
  const auto one = w.material(w.first.remote_writer, KeyStage::revised);
  const auto other = w.material(w.second.remote_writer, KeyStage::revised);
  EXPECT_EQ(revision_of(one.kind), 1u);
  EXPECT_FALSE(one.sender_key == other.sender_key);
  EXPECT_EQ(one.sender_key_id, w.material(w.first.remote_writer).sender_key_id);
  ASSERT_TRUE(w.two.take_reader(w.first, w.two.reader_tokens(w.first, KeyStage::revised).value()));
  ASSERT_TRUE(w.tell_second(KeyStage::revised));
  ASSERT_TRUE(b.factory().activate_key_revision(b.participant, revision));
  const auto to_first = w.reply_to({w.first.remote_writer}).value();
  const auto to_second = w.reply_to({w.second.remote_writer}).value();
  EXPECT_EQ(to_second[6], 1);
  EXPECT_EQ(decode_reply(w.two, w.first, to_first), acknack());
  EXPECT_EQ(w.read_at_second(to_second), acknack());
  EXPECT_EQ(w.read_at_second(former), acknack()) << "counts for a while";
  EXPECT_EQ(w.route_at_second(to_first), Code::unknown_key_id);
}

// A participant with all former keys gets no new ones.
TEST_P(PeerKeys, ParticipantThatIsNotTold_ReadsNoMore) {
  TwoWriters w(GetParam());
  auto& b = w.two.b;
  const auto revision = b.factory().revise_local_entity_keys(b.participant).value();
  ASSERT_TRUE(b.factory().activate_key_revision(b.participant, revision));
  const auto to_second = w.reply_to({w.second.remote_writer}).value();
  EXPECT_EQ(code_of(w.read_at_second(to_second)), Code::key_revision_unknown);
}

class ReceiverKeys : public ::testing::TestWithParam<ProtectionKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, ReceiverKeys, ::testing::Values(kSignOrigin, kEncryptOrigin));

TEST_P(ReceiverKeys, OneSubmessage_ServesWritersOfSeveralParticipantsOnly) {
  TwoWriters w(GetParam());
  const auto to_both = w.reply_to({w.first.remote_writer, w.second.remote_writer}).value();
  EXPECT_EQ(decode_reply(w.two, w.first, to_both), acknack());
  EXPECT_EQ(w.read_at_second(to_both), acknack());
  const auto to_first = w.reply_to({w.first.remote_writer}).value();
  EXPECT_EQ(code_of(w.read_at_second(to_first)), Code::receiver_specific_mac_missing);
  EXPECT_EQ(w.material(w.first.remote_writer).sender_key_id,
            w.material(w.second.remote_writer).sender_key_id);
}

// Gives random octets until it is broken.
struct BreakableRandom final : Random {
  Status fill(MutableBytes out) override {
    return is_broken ? Status(ddssec::fail(Code::random_failed)) : system.fill(out);
  }
  SystemRandom system;
  bool is_broken = false;
};

TEST(PeerKey, KeyThatCannotBeMade_LeavesNoMatch) {
  ManualClock clock{WallTime{}};
  test::RecordedEvents events;
  BreakableRandom random;
  const auto plugin = make_cryptography({clock, random, events}, {});
  auto& factory = plugin->key_factory();
  const auto participant =
      factory.register_local_participant({1}, {1}, {}, participant_attributes(kNone)).value();
  const auto remote =
      factory.register_matched_remote_participant(participant, {7}, {7}, shared_secret()).value();
  const auto reader =
      factory.register_local_datareader(participant, {}, endpoint_attributes(kEncrypt, kNone))
          .value();
  const auto match = [&] {
    return factory.register_matched_remote_datawriter(reader, remote, shared_secret());
  };
  random.is_broken = true;
  EXPECT_EQ(code_of(match()), Code::random_failed);
  random.is_broken = false;
  const auto writer = match().value();
  EXPECT_EQ(plugin->key_exchange().create_local_datareader_crypto_tokens(reader, writer)->size(),
            1u);
}

}  // namespace
}  // namespace ddssec::cryptography::testing
