// Handles, the life of what they stand for, and large numbers of them.
#include "plugins/cryptography/registry.hpp"

#include <ctime>
#include <set>

#include <gtest/gtest.h>

#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;

struct Thing final : CryptoEntity {
  Thing() : CryptoEntity(EntityKind::local_writer) {}
};

TEST(Registry, FullRegistry_RefusesMore) {
  Registry registry(42);
  const auto most = Registry::kChunkSize * Registry::kMaxChunks;
  std::int64_t last = 0;
  for (std::size_t i = 0; i < most; ++i) {
    auto thing = std::make_unique<Thing>();
    const auto& added = *thing;
    ASSERT_TRUE(registry.add(std::move(thing)));
    last = added.handle();
  }
  EXPECT_EQ(code_of(registry.add(std::make_unique<Thing>())), Code::crypto_too_many_entities);
  auto* const thing = registry.find<Thing>(last, EntityKind::local_writer).value();
  EXPECT_EQ(registry.remove(*thing)->handle(), last);
  EXPECT_TRUE(registry.add(std::make_unique<Thing>()));
  EXPECT_EQ(code_of(registry.find<Thing>(last, EntityKind::local_writer)),
            Code::crypto_handle_unknown);
}

TEST(Registry, Handles_ArePositiveAndDiffer) {
  for (const std::uint64_t first : {std::uint64_t{0}, ~std::uint64_t{0}, std::uint64_t{1} << 35}) {
    Registry registry(first);
    std::set<std::int64_t> seen;
    for (int i = 0; i < 100; ++i) {
      auto thing = std::make_unique<Thing>();
      const auto& added = *thing;
      ASSERT_TRUE(registry.add(std::move(thing)));
      EXPECT_GT(added.handle(), 0);
      EXPECT_TRUE(seen.insert(added.handle()).second);
      if (i % 2 == 0) registry.remove(added);
    }
  }
}

TEST(RetiredObjects, ObjectsWithoutReaders_AreFreedAtOnce) {
  RetiredObjects retired_objects;
  {
    const ReadGuard guard;
    retired_objects.retire(std::make_unique<Thing>());
    retired_objects.retire(std::make_unique<Thing>());
    EXPECT_EQ(retired_objects.size(), 2u);
  }
  retired_objects.retire(std::make_unique<Thing>());
  EXPECT_EQ(retired_objects.size(), 0u);
}

TEST(RegisteredMatches, SameRemoteIdentity_HasTheSameHandle) {
  Side side;
  auto& factory = side.factory();
  const auto attributes = participant_attributes(kEncrypt);
  const auto one = factory.register_local_participant({1}, {}, {}, attributes).value();
  const auto two = factory.register_local_participant({2}, {}, {}, attributes).value();
  const auto remote =
      factory.register_matched_remote_participant(one, {7}, {}, shared_secret(1)).value();
  EXPECT_EQ(factory.register_matched_remote_participant(two, {7}, {}, shared_secret(2)).value(),
            remote);
  EXPECT_NE(factory.register_matched_remote_participant(one, {8}, {}, shared_secret(3)).value(),
            remote);
  // Each pair has tokens of its own, but the remote is returned once for both.
  EXPECT_TRUE(side.exchange().create_local_participant_crypto_tokens(one, remote));
  EXPECT_TRUE(side.exchange().create_local_participant_crypto_tokens(two, remote));
  ASSERT_TRUE(factory.unregister_participant(remote));
  EXPECT_EQ(code_of(side.exchange().create_local_participant_crypto_tokens(one, remote)),
            Code::crypto_handle_unknown);
  EXPECT_EQ(code_of(factory.unregister_participant(remote)), Code::crypto_handle_unknown);
  const auto again = factory.register_matched_remote_participant(one, {7}, {}, shared_secret(1));
  EXPECT_NE(*again, remote);
}

TEST(RegisteredMatches, TwoLocalParticipants_EachReadTheRemoteByTheirOwnMac) {
  constexpr auto kOrigin = ProtectionKind::encrypt_with_origin_authentication;
  TwoSides two(kOrigin);
  auto& b = two.b;
  const auto second =
      b.factory().register_local_participant({5}, {}, {}, participant_attributes(kOrigin)).value();
  ASSERT_EQ(
      b.factory().register_matched_remote_participant(second, {7}, {}, shared_secret(9)).value(),
      b.remote);
  const auto plain = rtps_message({data_submessage(16)});
  auto encoded = encode_message(two, plain).value();
  Bytes out(encoded.size());
  const auto decode = [&] {
    return code_of(b.transform().decode_rtps_message(second, b.remote, encoded, out));
  };
  EXPECT_EQ(decode(), Code::key_material_not_received);
  const auto remote_second =
      two.a.factory()
          .register_matched_remote_participant(two.a.participant, {8}, {}, shared_secret(9))
          .value();
  const auto tokens =
      two.a.exchange().create_local_participant_crypto_tokens(two.a.participant, remote_second);
  ASSERT_TRUE(b.exchange().set_remote_participant_crypto_tokens(second, b.remote, *tokens));
  EXPECT_EQ(decode(), Code::message_from_before) << "try the next participant";
  EXPECT_TRUE(decode_message(two, encoded));
  encoded = encode_message(two, plain).value();
  EXPECT_EQ(decode(), Code::receiver_specific_mac_missing) << "try the next participant";
  EXPECT_TRUE(decode_message(two, encoded));
}

// A second local participant at `b`. It has the remote under `identity`, and a reader of its own.
struct SecondReader {
  SecondReader(TwoSides& two, IdentityHandle identity) : two_(two) {
    auto& b = two.b;
    auto& a = two.a;
    const auto attributes = endpoint_attributes(kEncrypt, kEncrypt);
    participant = b.factory()
                      .register_local_participant({5}, {}, {}, participant_attributes(kEncrypt))
                      .value();
    remote = b.factory()
                 .register_matched_remote_participant(participant, identity, {}, shared_secret(9))
                 .value();
    at_a = a.factory()
               .register_matched_remote_participant(a.participant, {8}, {}, shared_secret(9))
               .value();
    of_participant =
        a.exchange().create_local_participant_crypto_tokens(a.participant, at_a).value();
    b.exchange().set_remote_participant_crypto_tokens(participant, remote, of_participant).value();
    ends.writer = a.factory().register_local_datawriter(a.participant, {}, attributes).value();
    ends.reader = b.factory().register_local_datareader(participant, {}, attributes).value();
    ends.remote_reader =
        a.factory()
            .register_matched_remote_datareader(ends.writer, at_a, shared_secret(9), false)
            .value();
    ends.remote_writer =
        b.factory()
            .register_matched_remote_datawriter(ends.reader, remote, shared_secret(9))
            .value();
    const auto tokens =
        a.exchange().create_local_datawriter_crypto_tokens(ends.writer, ends.remote_reader).value();
    b.exchange()
        .set_remote_datawriter_crypto_tokens(ends.reader, ends.remote_writer, tokens)
        .value();
  }
  bool reads() {
    const auto message = encode_message(two_, rtps_message({data_submessage(16)})).value();
    Bytes out(message.size());
    return two_.b.transform().decode_rtps_message(participant, remote, message, out) &&
           decode_submessage(two_, ends,
                             encode_submessage(two_, ends, data_submessage(8)).value()) &&
           decode_payload(two_, ends, encode_payload(two_, ends, Bytes(8)).value());
  }

  ParticipantCryptoHandle participant, remote, at_a;
  std::vector<spi::Token> of_participant;
  WriterToReader ends;

 private:
  TwoSides& two_;
};

// True if the first local participant reads the messages for it.
bool first_reads(TwoSides& two, const WriterToReader& e) {
  return decode_message(two, encode_message(two, rtps_message({data_submessage(16)})).value()) &&
         decode_submessage(two, e, encode_submessage(two, e, data_submessage(8)).value()) &&
         decode_payload(two, e, encode_payload(two, e, Bytes(8)).value());
}

// The first local participant knows the remote as 7. The second one knows it under the same
// identity, or under one of its own.
TEST(RegistryOfTwoLocals, OneRemote_HasItsOwnKeysForEach) {
  for (const IdentityHandle identity : {IdentityHandle{7}, IdentityHandle{17}}) {
    TwoSides two(kEncrypt);
    const auto e = two.endpoints(endpoint_attributes(kEncrypt, kEncrypt));
    SecondReader second(two, identity);
    EXPECT_EQ(second.remote == two.b.remote, identity == IdentityHandle{7});
    EXPECT_TRUE(first_reads(two, e));
    EXPECT_TRUE(second.reads());
    // Neither participant opens the other one's messages, or accepts the other one's tokens.
    const auto& ends = second.ends;
    const auto encoded = encode_payload(two, ends, Bytes(8)).value();
    Bytes out(encoded.size());
    EXPECT_EQ(code_of(two.b.transform().decode_serialized_payload(e.reader, ends.remote_writer,
                                                                  encoded, out)),
              Code::crypto_not_matched);
    EXPECT_EQ(code_of(decode_payload(two, e, encoded)), Code::transform_key_id_mismatch);
    const auto tokens = two.writer_tokens(ends);
    EXPECT_EQ(code_of(two.b.exchange().set_remote_datawriter_crypto_tokens(
                  e.reader, ends.remote_writer, *tokens)),
              Code::crypto_not_matched);
    EXPECT_TRUE(first_reads(two, e));
    EXPECT_TRUE(second.reads());
  }
}

TEST(RegistryOfTwoLocals, WhenOneGoes_TheOtherReadsOn) {
  for (const bool second_goes : {false, true})
    for (const IdentityHandle identity : {IdentityHandle{7}, IdentityHandle{17}}) {
      TwoSides two(kEncrypt);
      const auto e = two.endpoints(endpoint_attributes(kEncrypt, kEncrypt));
      SecondReader second(two, identity);
      auto& factory = two.b.factory();
      ASSERT_TRUE(
          factory.unregister_participant(second_goes ? second.participant : two.b.participant));
      EXPECT_EQ(first_reads(two, e), second_goes);
      EXPECT_EQ(second.reads(), !second_goes);
    }
}

TEST(RegistryOfTwoLocals, IdentityForEachPair_IsReturnedByEachForItself) {
  for (const bool second_gives : {false, true}) {
    TwoSides two(kEncrypt);
    const auto e = two.endpoints(endpoint_attributes(kEncrypt, kEncrypt));
    SecondReader second(two, {17});
    ASSERT_TRUE(
        two.b.factory().unregister_participant(second_gives ? second.remote : two.b.remote));
    EXPECT_EQ(first_reads(two, e), second_gives);
    EXPECT_EQ(second.reads(), !second_gives);
  }
}

TEST(RegistryScale, TheFourThousandthRemote_CostsAsMuchAsTheFirst) {
  Side side;
  const auto local = side.factory()
                         .register_local_participant({}, {}, {}, participant_attributes(kEncrypt))
                         .value();
  const auto thousand = [&](std::int64_t from) {
    const auto start = std::clock();  // processor time, which a busy machine changes little
    for (std::int64_t i = 1; i <= 1000; ++i)
      side.factory()
          .register_matched_remote_participant(local, {from + i}, {}, shared_secret())
          .value();
    return std::clock() - start;
  };
  const auto first = thousand(0);
  thousand(1000), thousand(2000);
  const auto last = thousand(3000);
  EXPECT_LT(last, first * 20) << "a linear walk would take more";
}

}  // namespace
}  // namespace ddssec::cryptography::testing
