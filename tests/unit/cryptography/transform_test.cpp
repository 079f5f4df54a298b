// Round trips of all transformations, and what each of them refuses.
#include <gtest/gtest.h>

#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kSign = ProtectionKind::sign;
constexpr auto kNone = ProtectionKind::none;

constexpr std::array kKinds = {kSign, kEncrypt, ProtectionKind::sign_with_origin_authentication,
                               ProtectionKind::encrypt_with_origin_authentication};

TEST(Payload, EverySize_ComesBack) {
  for (const auto kind : {kSign, kEncrypt})
    for (const auto* const bits : {"128", "256"}) {
      TwoSides two(kNone, key_size(bits));
      const auto e = two.endpoints(endpoint_attributes(kNone, kind));
      for (const std::size_t size : {0u, 1u, 13u, 16u, 64u, 1000u, 65537u}) {
        const Bytes plain(size, 0x42);
        const auto encoded = encode_payload(two, e, plain).value();
        EXPECT_EQ(encoded.size(), size + (kind == kEncrypt ? 44 : 40));
        EXPECT_EQ(decode_payload(two, e, encoded).value(), plain);
      }
    }
}

// Fast DDS 2.9 pads a payload to whole words. Without this tolerance, samples of other lengths do
// not reach Cyclone DDS with our plugins.
TEST(Payload, OctetsUpToAWholeWordAfterItsFooter_AreNoPartOfIt) {
  TwoSides two;
  const auto e = two.endpoints(endpoint_attributes(kNone, kEncrypt));
  const Bytes plain(25, 0x42);
  for (std::size_t padding = 0; padding < 6; ++padding) {
    auto encoded = encode_payload(two, e, plain).value();
    encoded.resize(encoded.size() + padding);
    const auto decoded = decode_payload(two, e, encoded);
    EXPECT_EQ(code_of(decoded), padding < 4 ? Code{} : Code::secure_group_malformed) << padding;
    if (decoded) {
      EXPECT_EQ(*decoded, plain);
    }
  }
}

TEST(ProtectedSubmessage, EveryKindAndSize_ComesBackBothWays) {
  for (const auto kind : kKinds) {
    TwoSides two;
    const auto e = two.endpoints(endpoint_attributes(kind, kNone));
    for (const std::size_t size : {0u, 4u, 48u, 1000u, 65000u}) {
      const auto data = data_submessage(size), ack = data_submessage(size, 0x06);
      EXPECT_EQ(decode_submessage(two, e, encode_submessage(two, e, data).value()).value(), data);
      EXPECT_EQ(decode_reply(two, e, encode_reply(two, e, ack).value()).value(), ack);
    }
  }
}

TEST(ProtectedMessage, EveryKind_ComesBackWithItsSourceInFront) {
  for (const auto kind : kKinds) {
    TwoSides two(kind);
    const auto plain = rtps_message({data_submessage(12), data_submessage(100)});
    const auto decoded = decode_message(two, encode_message(two, plain).value()).value();
    ASSERT_EQ(decoded.size(), plain.size() + 24);
    EXPECT_EQ(to_hex(BytesView(decoded).first(20)), to_hex(BytesView(plain).first(20)));
    EXPECT_EQ(decoded[20], 0x0c);
    EXPECT_EQ(to_hex(BytesView(decoded).subspan(28, 16)), to_hex(BytesView(plain).subspan(4, 16)));
    EXPECT_EQ(to_hex(BytesView(decoded).subspan(44)), to_hex(BytesView(plain).subspan(20)));
  }
}

// Fast DDS 2.9 appends its statistics submessage after SRTPS_POSTFIX.
TEST(ProtectedMessage, WhatFollowsThePostfix_IsLost) {
  for (auto kind : kKinds) {
    TwoSides two(kind);
    const auto plain = rtps_message({data_submessage(12)});
    const auto alone = decode_message(two, encode_message(two, plain).value()).value();
    auto encoded = encode_message(two, plain).value();
    Bytes statistics(60);
    statistics[0] = 0x80;
    statistics[1] = 1;
    statistics[2] = 56;
    encoded.insert(encoded.end(), statistics.begin(), statistics.end());
    EXPECT_EQ(decode_message(two, encoded), alone);
  }
}

TEST(Volatile, BeforeAnyToken_ComesBackBothWays) {
  TwoSides two;
  const auto e = two.volatile_endpoints();
  const auto data = data_submessage(60, 0x07), ack = data_submessage(24, 0x06);
  const auto encoded = encode_submessage(two, e, data).value();
  EXPECT_EQ(to_hex(BytesView(encoded).subspan(4, 8)), "0000000400000000");
  EXPECT_EQ(decode_submessage(two, e, encoded).value(), data);
  EXPECT_EQ(decode_reply(two, e, encode_reply(two, e, ack).value()).value(), ack);
  const auto whose = two.b.transform().preprocess_secure_submessage({}, two.b.remote, encoded);
  EXPECT_EQ(whose->category, spi::SecureSubmessageCategory::datawriter);
  EXPECT_EQ(whose->datawriter, e.remote_writer);
}

TEST(Volatile, OwnMessageSentBack_IsNotTheOthers) {
  TwoSides two(kNone, {}, {.max_blocks_per_session = 8});
  const auto e = two.volatile_endpoints();
  std::vector<Bytes> said;
  for (int i = 0; i < 20; ++i)  // this takes several sessions
    said.push_back(encode_submessage(two, e, data_submessage(60, 0x07)).value());
  for (const auto& own : said) {
    EXPECT_EQ(code_of(decode_reply(two, e, own)), Code::key_exchange_reflected);
    EXPECT_TRUE(decode_submessage(two, e, own));
  }
  const auto ack = encode_reply(two, e, data_submessage(24, 0x06)).value();
  EXPECT_EQ(code_of(decode_submessage(two, e, ack)), Code::key_exchange_reflected);
  EXPECT_TRUE(decode_reply(two, e, ack));
}

TEST(Volatile, NoneOrTwoReceivers_AreRefused) {
  TwoSides two;
  const auto e = two.volatile_endpoints();
  Bytes out(300);
  EXPECT_EQ(code_of(two.a.transform().encode_datawriter_submessage(e.writer, {}, data_submessage(8),
                                                                   out)),
            Code::receiver_count);
  const std::array both = {e.remote_reader, e.remote_reader};
  EXPECT_EQ(code_of(two.a.transform().encode_datawriter_submessage(e.writer, both,
                                                                   data_submessage(8), out)),
            Code::receiver_count);
}

TEST(Volatile, AnotherSecret_IsAnotherKey) {
  TwoSides two;
  const auto e = two.volatile_endpoints();
  const auto before = encode_submessage(two, e, data_submessage(8, 0x07)).value();
  TwoSides::match(two.b, 77);  // authenticated again
  EXPECT_EQ(code_of(decode_submessage(two, e, before)), Code::tag_mismatch);
  TwoSides::match(two.a, 77);
  EXPECT_TRUE(
      decode_submessage(two, e, encode_submessage(two, e, data_submessage(8, 0x07)).value()));
}

TEST(FailClosed, PairWithoutTokens_OpensNothing) {
  TwoSides two(kEncrypt);
  const auto e = two.endpoints(endpoint_attributes(kEncrypt, kEncrypt));
  const auto message = encode_message(two, rtps_message({data_submessage(8)})).value();
  const auto submessage = encode_submessage(two, e, data_submessage(8)).value();
  const auto payload = encode_payload(two, e, Bytes(8)).value();
  TwoSides::match(two.b, 99);  // a new pair has no tokens yet
  EXPECT_EQ(code_of(decode_message(two, message)), Code::key_material_not_received);
  auto fresh = e;
  fresh.remote_writer =
      two.b.factory()
          .register_matched_remote_datawriter(e.reader, two.b.remote, shared_secret())
          .value();
  EXPECT_EQ(code_of(decode_submessage(two, fresh, submessage)), Code::key_material_not_received);
  EXPECT_EQ(code_of(decode_payload(two, fresh, payload)), Code::key_material_not_received);
}

TEST(Receivers, EachReader_FindsItsOwnMac) {
  TwoSides two;
  const auto attributes =
      endpoint_attributes(ProtectionKind::encrypt_with_origin_authentication, kNone);
  auto first = two.endpoints(attributes);
  auto second = first;
  second.reader =
      two.b.factory().register_local_datareader(two.b.participant, {}, attributes).value();
  two.match_endpoints(second);
  const auto data = data_submessage(16);
  const auto only_second = encode_submessage(two, second, data).value();
  EXPECT_EQ(decode_submessage(two, second, only_second).value(), data);
  EXPECT_EQ(code_of(decode_submessage(two, first, only_second)),
            Code::receiver_specific_mac_missing);
  const auto whose = two.b.transform().preprocess_secure_submessage({}, two.b.remote, only_second);
  EXPECT_EQ(whose->datawriter, second.remote_writer);
  EXPECT_EQ(whose->datareader, second.reader);
  const std::array both = {first.remote_reader, second.remote_reader};
  const auto to_both = into_bytes(400, [&](MutableBytes out) {
    return two.a.transform().encode_datawriter_submessage(first.writer, both, data, out);
  });
  EXPECT_EQ(decode_submessage(two, first, *to_both).value(), data);
  EXPECT_EQ(decode_submessage(two, second, *to_both).value(), data);
}

// The host may list a receiver that is unregistered before the message is encoded.
TEST(Receivers, RemainingReceivers_FindTheirMacAfterOneHasLeft) {
  for (const auto kind : {ProtectionKind::encrypt_with_origin_authentication,
                          ProtectionKind::sign_with_origin_authentication}) {
    TwoSides two;
    const auto attributes = endpoint_attributes(kind, kNone);
    auto first = two.endpoints(attributes);
    auto second = first;
    second.reader =
        two.b.factory().register_local_datareader(two.b.participant, {}, attributes).value();
    two.match_endpoints(second);
    ASSERT_TRUE(two.a.factory().unregister_datareader(first.remote_reader));
    const auto data = data_submessage(16);
    for (const auto& both : {std::array{first.remote_reader, second.remote_reader},
                             std::array{second.remote_reader, first.remote_reader}}) {
      const auto encoded = into_bytes(400, [&](MutableBytes out) {
        return two.a.transform().encode_datawriter_submessage(first.writer, both, data, out);
      });
      ASSERT_TRUE(encoded);
      EXPECT_EQ(decode_submessage(two, second, *encoded).value(), data);
    }
  }
}

TEST(Preprocess, WritersAndReaders_AreToldApart) {
  TwoSides two;
  const auto e = two.endpoints(endpoint_attributes(kEncrypt, kEncrypt));
  const auto data = encode_submessage(two, e, data_submessage(8)).value();
  const auto from_writer =
      two.b.transform().preprocess_secure_submessage(two.b.participant, two.b.remote, data);
  EXPECT_EQ(from_writer->category, spi::SecureSubmessageCategory::datawriter);
  EXPECT_EQ(from_writer->datawriter, e.remote_writer);
  EXPECT_EQ(from_writer->datareader, e.reader);
  const auto ack = encode_reply(two, e, data_submessage(8, 0x06)).value();
  const auto from_reader =
      two.a.transform().preprocess_secure_submessage(two.a.participant, two.a.remote, ack);
  EXPECT_EQ(from_reader->category, spi::SecureSubmessageCategory::datareader);
  EXPECT_EQ(from_reader->datareader, e.remote_reader);
  EXPECT_EQ(from_reader->datawriter, e.writer);
}

TEST(Preprocess, UnmatchedEndpoints_AreUnknown) {
  TwoSides two;
  auto data = Bytes(80);
  EXPECT_EQ(code_of(two.b.transform().preprocess_secure_submessage({}, two.b.remote, data)),
            Code::secure_group_malformed);
  const auto e = two.endpoints(endpoint_attributes(kEncrypt, kNone));
  data = encode_submessage(two, e, data_submessage(8)).value();
  const auto stranger =
      two.b.factory().register_local_participant({}, {}, {}, participant_attributes(kNone)).value();
  EXPECT_EQ(code_of(two.b.transform().preprocess_secure_submessage(stranger, two.b.remote, data)),
            Code::unknown_key_id);
  ASSERT_TRUE(two.b.factory().unregister_datawriter(e.remote_writer));
  EXPECT_EQ(code_of(two.b.transform().preprocess_secure_submessage({}, two.b.remote, data)),
            Code::unknown_key_id);
}

TEST(CycloneHost, HeaderPrefixInHostOrder_IsComparedAsSuch) {
  TwoSides two(kEncrypt, {}, {.header_prefix_is_network_order = false});
  const auto plain = rtps_message({data_submessage(8)});
  auto encoded = encode_message(two, plain).value();
  EXPECT_EQ(code_of(decode_message(two, encoded)), Code::info_source_mismatch);
  for (std::size_t word = 8; word < 20; word += 4)
    std::reverse(encoded.begin() + static_cast<std::ptrdiff_t>(word),
                 encoded.begin() + static_cast<std::ptrdiff_t>(word) + 4);
  const auto decoded = decode_message(two, encoded).value();
  EXPECT_EQ(to_hex(BytesView(decoded).first(20)), to_hex(BytesView(plain).first(20)))
      << "the rebuilt header is in network order";
}

}  // namespace
}  // namespace ddssec::cryptography::testing
