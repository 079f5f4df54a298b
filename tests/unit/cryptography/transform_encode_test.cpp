// What is encoded: only whole submessages, only into enough room, and only for receivers that
// exist.
#include <gtest/gtest.h>

#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kSign = ProtectionKind::sign;
constexpr auto kNone = ProtectionKind::none;

constexpr std::array kKinds = {kSign, kEncrypt, ProtectionKind::sign_with_origin_authentication,
                               ProtectionKind::encrypt_with_origin_authentication};

TEST(FailClosed, UnprotectedLevels_TransformNothing) {
  TwoSides two;
  const auto open = two.endpoints(endpoint_attributes(kNone, kNone));
  EXPECT_EQ(code_of(encode_payload(two, open, Bytes(8))), Code::not_protected);
  EXPECT_EQ(code_of(decode_payload(two, open, Bytes(80))), Code::not_protected);
  EXPECT_EQ(code_of(encode_submessage(two, open, data_submessage(8))), Code::not_protected);
  EXPECT_EQ(code_of(decode_submessage(two, open, Bytes(80))), Code::not_protected);
  EXPECT_EQ(code_of(encode_reply(two, open, data_submessage(8))), Code::not_protected);
  EXPECT_EQ(code_of(decode_reply(two, open, Bytes(80))), Code::not_protected);
  EXPECT_EQ(code_of(encode_message(two, rtps_message({data_submessage(8)}))), Code::not_protected);
  EXPECT_EQ(code_of(decode_message(two, Bytes(80))), Code::not_protected);
  const auto payload_only = two.endpoints(endpoint_attributes(kNone, kEncrypt));
  EXPECT_EQ(code_of(encode_submessage(two, payload_only, data_submessage(8))), Code::not_protected);
  EXPECT_EQ(code_of(encode_reply(two, payload_only, data_submessage(8))), Code::not_protected);
}

TEST(Plaintext, OtherThanWholeSubmessagesInWords_IsRefused) {
  TwoSides two(kSign);
  const auto e = two.endpoints(endpoint_attributes(kEncrypt, kNone));
  const auto expect_refused = [&](Bytes plain) {
    EXPECT_EQ(code_of(encode_submessage(two, e, plain)), Code::plaintext_malformed);
  };
  expect_refused({});
  expect_refused({0x15, 1, 0});
  auto uneven = data_submessage(8);
  uneven.pop_back();
  expect_refused(uneven);
  auto longer = data_submessage(8);
  longer[2] = 12;
  expect_refused(longer);
  expect_refused(data_submessage(65536));
  const auto refuse_message = [&](const Bytes& plain) {
    EXPECT_EQ(code_of(encode_message(two, plain)), Code::plaintext_malformed);
  };
  refuse_message({});
  refuse_message(rtps_message({}));
  refuse_message(Bytes(64));
  refuse_message(rtps_message({longer}));
  TwoSides encrypting(kEncrypt);
  EXPECT_EQ(code_of(encode_message(encrypting, rtps_message({}))), Code::plaintext_malformed);
  EXPECT_EQ(code_of(encode_message(encrypting, rtps_message({Bytes(65536)}))),
            Code::plaintext_malformed);
}

TEST(Plaintext, LengthToTheEnd_IsClosed) {
  for (const auto kind : {kSign, kEncrypt}) {
    TwoSides two(kind);
    const auto e = two.endpoints(endpoint_attributes(kind, kNone));
    auto open = data_submessage(40);
    open[2] = open[3] = 0;
    EXPECT_EQ(decode_submessage(two, e, encode_submessage(two, e, open).value()).value(),
              data_submessage(40));
    auto big_endian = open;
    big_endian[1] = 0x04;
    const auto closed =
        decode_submessage(two, e, encode_submessage(two, e, big_endian).value()).value();
    EXPECT_EQ(to_hex(BytesView(closed).first(4)), "15040028");
    const auto message = rtps_message({data_submessage(8), open});
    EXPECT_TRUE(decode_message(two, encode_message(two, message).value()));
  }
}

TEST(Output, TooLittleRoom_IsRefusedAndStaysUntouched) {
  for (const auto kind : kKinds) {
    TwoSides two(kind);
    const auto e = two.endpoints(endpoint_attributes(kind, is_encrypted(kind) ? kEncrypt : kSign));
    const auto data = data_submessage(20);
    const auto needed = encode_submessage(two, e, data)->size();
    for (std::size_t room = 0; room < needed; ++room) {
      Bytes out(room, 0xaa);
      EXPECT_EQ(code_of(two.a.transform().encode_datawriter_submessage(
                    e.writer, {&e.remote_reader, 1}, data, out)),
                Code::length_out_of_range);
      EXPECT_EQ(out, Bytes(room, 0xaa));
    }
    const auto message = rtps_message({data});
    const auto message_size = encode_message(two, message)->size();
    for (std::size_t room = 0; room < message_size; ++room) {
      Bytes out(room, 0xaa);
      EXPECT_EQ(code_of(two.a.transform().encode_rtps_message(two.a.participant, {&two.a.remote, 1},
                                                              message, out)),
                Code::length_out_of_range);
    }
    const auto payload = encode_payload(two, e, Bytes(21)).value();
    Bytes small(20);
    EXPECT_EQ(code_of(two.b.transform().decode_serialized_payload(e.reader, e.remote_writer,
                                                                  payload, small)),
              Code::length_out_of_range);
    Bytes short_of_payload(payload.size() - 1);
    EXPECT_EQ(
        code_of(two.a.transform().encode_serialized_payload(e.writer, Bytes(21), short_of_payload)),
        Code::length_out_of_range);
    const auto sealed = encode_message(two, message).value();
    for (const std::size_t room : {0u, 19u, 30u}) {
      Bytes out(room);
      EXPECT_EQ(code_of(two.b.transform().decode_rtps_message(two.b.participant, two.b.remote,
                                                              sealed, out)),
                Code::length_out_of_range);
    }
  }
}

TEST(Output, Overhead_SufficesForAnyNumberOfReceivers) {
  for (const auto kind : kKinds)
    for (const std::size_t receivers : {1u, 2u, 64u}) {
      TwoSides two(kind);
      const std::vector list(receivers, two.a.remote);
      const auto plain = rtps_message({data_submessage(16)});
      EXPECT_TRUE(into_bytes(plain.size() + spi::protection_overhead(receivers), [&](auto out) {
        return two.a.transform().encode_rtps_message(two.a.participant, list, plain, out);
      }));
    }
}

TEST(Receivers, NoneOrTooMany_AreRefusedWithOriginAuthentication) {
  TwoSides two(ProtectionKind::sign_with_origin_authentication);
  const auto plain = rtps_message({data_submessage(16)});
  Bytes out(200000);
  const std::vector many(3276, two.a.remote), most(3275, two.a.remote);
  const auto encode = [&](std::span<const ParticipantCryptoHandle> list) {
    return code_of(two.a.transform().encode_rtps_message(two.a.participant, list, plain, out));
  };
  EXPECT_EQ(encode({}), Code::receiver_count);
  EXPECT_EQ(encode(many), Code::receiver_count);
  EXPECT_EQ(encode(most), Code{0});
}

TEST(Sizes, EitherSide_ChoosesItsOwn) {
  TwoSides two;
  const auto e =
      two.endpoints(endpoint_attributes(kEncrypt, kEncrypt), key_size("128"), key_size("256"));
  EXPECT_TRUE(decode_payload(two, e, encode_payload(two, e, Bytes(40)).value()));
  EXPECT_TRUE(decode_reply(two, e, encode_reply(two, e, data_submessage(8, 0x06)).value()));
}

}  // namespace
}  // namespace ddssec::cryptography::testing
