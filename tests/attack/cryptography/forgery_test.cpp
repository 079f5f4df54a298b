// Messages that an attacker on the network, or a hostile authenticated peer, may send (T27, T28,
// T29, T42, T43 and T45 in docs/attacks.md).
#include <gmock/gmock.h>

#include "tests/support/seeded_random.hpp"
#include "tests/unit/cryptography/insider.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kSign = ProtectionKind::sign;
constexpr auto kNone = ProtectionKind::none;
constexpr auto kSignOrigin = ProtectionKind::sign_with_origin_authentication;
constexpr auto kEncryptOrigin = ProtectionKind::encrypt_with_origin_authentication;
constexpr std::array kKinds = {kSign, kEncrypt, kSignOrigin, kEncryptOrigin};

// A changed, shortened or invented message is refused with one of these.
const auto kRefusal = ::testing::AnyOf(
    Code::not_protected, Code::secure_group_malformed, Code::secure_flags_unsupported,
    Code::crypto_header_kind_unknown, Code::transform_kind_mismatch,
    Code::transform_key_id_mismatch, Code::unknown_key_id, Code::tag_mismatch,
    Code::receiver_specific_mac_missing, Code::receiver_specific_mac_mismatch,
    Code::receiver_specific_macs_not_allowed, Code::info_source_mismatch, Code::message_from_before,
    Code::key_revision_unknown, Code::signed_where_encryption_is_due);

using Decode = std::function<Result<Bytes>(const Bytes&)>;

struct Target {
  std::string name;
  std::function<Bytes()> encode;  // returns the same content each time, under another IV
  Decode decode;
};

// A genuine message of every kind at every level, with its reader.
class ForgedMessages : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const auto name : {spi::kAes128Name, spi::kAes256Name, spi::kChaCha20Poly1305Name})
      add_all_kinds(name);
  }
  void add_all_kinds(std::string_view cipher_name) {
    for (const auto kind : kKinds) {
      auto& two = *sides_.emplace_back(std::make_unique<TwoSides>(kind, cipher(cipher_name, true)));
      const auto e =
          two.endpoints(endpoint_attributes(kind, is_encrypted(kind) ? kEncrypt : kSign));
      const auto name = std::string(cipher_name) + " " + std::string(to_string(kind));
      targets_.push_back({name + " payload",
                          [&two, e] { return encode_payload(two, e, Bytes(22, 3)).value(); },
                          [&two, e](const Bytes& in) { return decode_payload(two, e, in); }});
      targets_.push_back(
          {name + " submessage",
           [&two, e] { return encode_submessage(two, e, data_submessage(24)).value(); },
           [&two, e](const Bytes& in) { return decode_submessage(two, e, in); }});
      targets_.push_back(
          {name + " reply",
           [&two, e] { return encode_reply(two, e, data_submessage(24, 0x06)).value(); },
           [&two, e](const Bytes& in) { return decode_reply(two, e, in); }});
      targets_.push_back({name + " message",
                          [&two] {
                            return encode_message(
                                       two, rtps_message({data_submessage(12), data_submessage(8)}))
                                .value();
                          },
                          [&two](const Bytes& in) { return decode_message(two, in); }});
    }
  }
  std::vector<std::unique_ptr<TwoSides>> sides_;
  std::vector<Target> targets_;
};

TEST_F(ForgedMessages, BitFlippedAnywhere_IsRefused) {
  for (const auto& target : targets_) {
    const auto honest = target.encode();
    ASSERT_TRUE(target.decode(target.encode())) << target.name;
    for (std::size_t bit = 0; bit < 8 * honest.size(); ++bit) {
      auto bad = honest;
      bad[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
      EXPECT_THAT(code_of(target.decode(bad)), kRefusal) << target.name << " octet " << bit / 8;
    }
    EXPECT_TRUE(target.decode(honest)) << "a forgery must not harm the honest " << target.name;
  }
}

// Octets after a complete message are not protected, and are dropped. (Fast DDS sends statistics
// there.)
TEST_F(ForgedMessages, Truncated_IsRefusedAndExtendedAddsNothing) {
  for (const auto& target : targets_) {
    const auto honest = target.decode(target.encode()).value();
    const auto encoded = target.encode();
    for (std::size_t size = 0; size < encoded.size(); ++size)
      EXPECT_THAT(code_of(target.decode(
                      Bytes(encoded.begin(), encoded.begin() + static_cast<std::ptrdiff_t>(size)))),
                  kRefusal)
          << target.name << size;
    for (const std::size_t more : {1u, 4u, 20u, 24u}) {
      auto longer = target.encode();
      longer.resize(longer.size() + more);
      const auto decoded = target.decode(longer);
      // Fast DDS pads an encrypted payload to whole words after the footer.
      const bool is_padding =
          more < 4 && target.name.contains("ENCRYPT") && target.name.ends_with(" payload");
      EXPECT_EQ(decoded.has_value(), is_padding || target.name.ends_with(" message"))
          << target.name << ' ' << more;
      EXPECT_EQ(decoded.value_or(honest), honest) << target.name;
    }
  }
}

// The exception is a postfix length of 0, which means the same.
TEST_F(ForgedMessages, EveryOctetAtItsExtremes_IsRefusedOrMeansTheSame) {
  for (const auto& target : targets_) {
    const auto encoded = target.encode();
    const auto honest = target.decode(encoded).value();
    std::size_t accepted = 0;
    for (std::size_t at = 0; at < encoded.size(); ++at)
      for (const std::uint8_t value : {0x00, 0x7f, 0x80, 0xff}) {
        auto bad = target.encode();
        if (std::exchange(bad[at], value) == value) continue;
        const auto decoded = target.decode(bad);
        if (!decoded) continue;
        EXPECT_EQ(*decoded, honest) << target.name << " octet " << at;
        ++accepted;
      }
    EXPECT_LE(accepted, 1u) << target.name;
  }
}

TEST_F(ForgedMessages, ShortAndEmptyDatagrams_AreRefused) {
  for (const auto& target : targets_)
    for (std::size_t size = 0; size <= 64; ++size)
      for (const std::uint8_t fill : {0x00, 0x01, 0x31, 0x33, 0xff})
        EXPECT_THAT(code_of(target.decode(Bytes(size, fill))), kRefusal) << target.name << size;
  Bytes out(100);
  auto& two = *sides_.front();
  for (std::size_t size = 0; size <= 64; ++size)
    EXPECT_THAT(code_of(two.b.transform().preprocess_secure_submessage({}, two.b.remote,
                                                                       Bytes(size, 0x31))),
                kRefusal)
        << size;
}

TEST_F(ForgedMessages, MessagesOfOneKind_DoNotPassAsAnother) {
  for (const auto& target : targets_)
    for (const auto& other : targets_)
      EXPECT_EQ(target.decode(other.encode()).has_value(), target.name == other.name);
}

// ---- exact reasons, by which participant holds the key

struct Payload {
  TwoSides two;
  WriterToReader e;
  explicit Payload(ProtectionKind kind) : e(two.endpoints(endpoint_attributes(kNone, kind))) {}
  Code decode(Bytes encoded) { return code_of(decode_payload(two, e, encoded)); }
};

TEST(RefusalReasons, ChangedKindAndKeyId_HaveTheirOwnReasons) {
  Payload encrypts(kEncrypt), signs(kSign);
  const auto sealed = encode_payload(encrypts.two, encrypts.e, Bytes(16, 1)).value();
  const auto with_kind = [&](Bytes octets, std::uint8_t kind) {
    octets[3] = kind;
    return octets;
  };
  EXPECT_EQ(encrypts.decode(with_kind(sealed, 3)), Code::signed_where_encryption_is_due);
  EXPECT_EQ(encrypts.decode(with_kind(sealed, 2)), Code::transform_kind_mismatch);
  for (const std::uint8_t kind : {0, 5, 0x80, 0xff})
    EXPECT_EQ(encrypts.decode(with_kind(sealed, kind)), Code::crypto_header_kind_unknown);
  auto revised = sealed;
  revised[2] = 1;
  EXPECT_EQ(encrypts.decode(revised), Code::key_revision_unknown);
  auto other_key = sealed;
  other_key[7] ^= 1;
  EXPECT_EQ(encrypts.decode(other_key), Code::transform_key_id_mismatch);
  // The content can be read as CryptoContent.
  Bytes plain(16);
  plain[3] = 12;
  const auto signed_one = encode_payload(signs.two, signs.e, plain).value();
  EXPECT_EQ(signs.decode(with_kind(signed_one, 4)), Code::encrypted_where_signature_is_due);
}

TEST(RefusalReasons, ChangedTags_AreTagMismatches) {
  for (const auto kind : {kSign, kEncrypt}) {
    Payload one(kind);
    const auto good = encode_payload(one.two, one.e, Bytes(16, 1)).value();
    auto zero_tag = good;
    std::fill_n(zero_tag.end() - 20, 16, std::uint8_t{0});
    EXPECT_EQ(one.decode(zero_tag), Code::tag_mismatch);
    auto other_session = good;
    other_session[9] ^= 0x10;
    EXPECT_EQ(one.decode(other_session), Code::tag_mismatch);
    auto macs = good;
    macs.back() = 1;
    macs.resize(macs.size() + 20);
    macs[macs.size() - 1] = 1;
    EXPECT_EQ(one.decode(macs), Code::receiver_specific_macs_not_allowed);
    EXPECT_EQ(one.decode(good), Code{0});
  }
}

TEST(RefusalReasons, WhatDidNotVerify_DoesNotStay) {
  for (const auto kind : kKinds) {
    TwoSides two(kind);
    auto bad = encode_message(two, rtps_message({data_submessage(40)})).value();
    bad[bad.size() - 30] ^= 1;  // the common MAC, or an octet before it
    Bytes out(bad.size(), 0);
    EXPECT_EQ(
        code_of(two.b.transform().decode_rtps_message(two.b.participant, two.b.remote, bad, out)),
        Code::tag_mismatch);
    EXPECT_EQ(out, Bytes(bad.size()));
  }
}

TEST(RefusalReasons, ChangedReceiverMacs_HaveTheirOwnReasons) {
  for (const auto kind : {kSignOrigin, kEncryptOrigin}) {
    TwoSides two(kind);
    const auto good = encode_message(two, rtps_message({data_submessage(40)})).value();
    auto wrong = good;
    wrong.back() ^= 1;
    EXPECT_EQ(code_of(decode_message(two, wrong)), Code::receiver_specific_mac_mismatch);
    auto others = good;
    others[others.size() - 20] ^= 1;
    EXPECT_EQ(code_of(decode_message(two, others)), Code::receiver_specific_mac_missing);
    auto none = good;
    none.resize(none.size() - 20);
    none[none.size() - 1] = 0;
    none[none.size() - 22] = 20;  // octetsToNextHeader of the postfix
    EXPECT_EQ(code_of(decode_message(two, none)), Code::receiver_specific_mac_missing);
    for (const std::uint32_t count : {0u, 2u, 65535u, 0x7fffffffu, 0xccccccceu, 0xffffffffu}) {
      auto lie = good;
      for (int i = 0; i < 4; ++i)
        lie[lie.size() - 24 + static_cast<std::size_t>(i)] =
            static_cast<std::uint8_t>(count >> (24 - 8 * i));
      EXPECT_EQ(code_of(decode_message(two, lie)), Code::secure_group_malformed) << count;
    }
  }
}

// 3,275 MACs for other receivers do not keep a receiver from finding, or missing, its own.
TEST(RefusalReasons, FullListOfReceiverMacs_IsSearched) {
  TwoSides two(kEncryptOrigin);
  const auto good = encode_message(two, rtps_message({data_submessage(40)})).value();
  auto full = good;
  const auto footer = good.size() - 20 - 20 - 4;
  Bytes strangers(20 * std::size_t{3274}, 0x99);
  full.insert(full.end() - 20, strangers.begin(), strangers.end());
  const std::size_t length = 20 + 20 * std::size_t{3275};
  full[footer + 2] = static_cast<std::uint8_t>(length), full[footer + 3] = length >> 8;
  full[footer + 4 + 18] = 3275 >> 8, full[footer + 4 + 19] = 3275 & 0xff;
  EXPECT_TRUE(decode_message(two, full));
  full[full.size() - 20] ^= 1;
  EXPECT_EQ(code_of(decode_message(two, full)), Code::receiver_specific_mac_missing);
}

TEST(RefusalReasons, FlagsOfLaterVersions_AreRefused) {
  TwoSides two(kEncrypt);
  const auto good = encode_message(two, rtps_message({data_submessage(40)})).value();
  for (const std::uint8_t flag : {0x02, 0x04, 0x80}) {
    auto bad = good;
    bad[21] |= flag;
    EXPECT_EQ(code_of(decode_message(two, bad)), Code::secure_flags_unsupported);
  }
}

TEST(RefusalReasons, AnotherSourceOutsideThanInside_IsRefused) {
  for (const auto kind : {kSign, kEncrypt}) {
    TwoSides two(kind);
    const auto good = encode_message(two, rtps_message({data_submessage(40)})).value();
    for (std::size_t at = 4; at < 20; ++at) {
      auto bad = good;
      bad[at] ^= 1;
      Bytes out(bad.size());
      EXPECT_EQ(
          code_of(two.b.transform().decode_rtps_message(two.b.participant, two.b.remote, bad, out)),
          Code::info_source_mismatch);
      EXPECT_EQ(out, Bytes(out.size()));
    }
  }
}

TEST(RefusalReasons, PostfixLengthZero_MeansToTheEnd) {
  TwoSides two(kEncrypt);
  auto encoded = encode_message(two, rtps_message({data_submessage(40)})).value();
  encoded[encoded.size() - 22] = 0;
  EXPECT_TRUE(decode_message(two, encoded)) << "OpenDDS writes it so";
}

TEST(InsiderMessages, MessageWithoutItsSourceFirst_IsRefused) {
  for (const auto kind : {kSign, kEncrypt}) {
    TwoSides two(kind);
    Insider insider(kind_for(Cipher::aes256_gcm, is_encrypted(kind)));
    const auto token = insider.token();
    ASSERT_TRUE(two.take_participant({&token, 1}));
    for (const auto& content : {data_submessage(40), data_submessage(0), Bytes{}}) {
      auto encoded = rtps_message({insider.group(kMessageFrame, content)});
      EXPECT_EQ(code_of(decode_message(two, encoded)), Code::info_source_missing);
    }
  }
}

TEST(InsiderSubmessages, SubmessageThatTheKeyOwnerNeverSends_IsRefused) {
  for (const auto kind : {kSign, kEncrypt}) {
    TwoSides two;
    const auto e = two.endpoints(endpoint_attributes(kind, kNone));
    Insider insider(kind_for(Cipher::aes128_gcm, is_encrypted(kind)));
    const auto token = insider.token();
    ASSERT_TRUE(two.take_writer(e, {&token, 1}));
    ASSERT_TRUE(two.take_reader(e, {&token, 1}));
    const auto by_writer = [&](const Bytes& content) {
      return code_of(decode_submessage(two, e, insider.group(kSubmessageFrame, content)));
    };
    const auto by_reader = [&](const Bytes& content) {
      return code_of(decode_reply(two, e, insider.group(kSubmessageFrame, content)));
    };
    for (const std::uint8_t id : {0x15, 0x16, 0x07, 0x13, 0x08, 0x09}) {
      EXPECT_EQ(by_writer(data_submessage(8, id)), Code{0});
      EXPECT_EQ(by_reader(data_submessage(8, id)), Code::submessage_not_of_sender);
    }
    for (const std::uint8_t id : {0x06, 0x12}) {
      EXPECT_EQ(by_reader(data_submessage(8, id)), Code{0});
      EXPECT_EQ(by_writer(data_submessage(8, id)), Code::submessage_not_of_sender);
    }
    for (const std::uint8_t id : {0x0c, 0x0e, 0x0f, 0x31, 0x33})
      EXPECT_EQ(by_writer(data_submessage(8, id)), Code::submessage_not_of_sender);
  }
}

TEST(InsiderSubmessages, NoneOrSeveralSubmessages_AreRefused) {
  TwoSides two;
  const auto e = two.endpoints(endpoint_attributes(kEncrypt, kNone));
  Insider insider(kAes256Gcm);
  const auto token = insider.token();
  ASSERT_TRUE(two.take_writer(e, {&token, 1}));
  auto pair = data_submessage(8);
  const auto second = data_submessage(8);
  pair.insert(pair.end(), second.begin(), second.end());
  auto too_long = data_submessage(8);
  too_long[2] = 12;
  auto uneven = data_submessage(9);
  for (const auto& content : {pair, too_long, uneven, Bytes{}, Bytes(3), Bytes{0x15, 1}})
    EXPECT_EQ(code_of(decode_submessage(two, e, insider.group(kSubmessageFrame, content))),
              Code::secure_group_malformed);
}

// The lengths in CryptoContent and SEC_BODY have extreme values. (Fast DDS once overflowed here.)
TEST(MessageLengths, BodyLengthsAtExtremes_AreRefused) {
  TwoSides two(kEncrypt);
  const auto good = encode_message(two, rtps_message({data_submessage(40)})).value();
  for (const std::uint32_t value :
       {0u, 1u, 67u, 69u, 71u, 0x7fffffffu, 0x80000000u, 0xfffffffcu, 0xfffffffdu, 0xffffffffu}) {
    auto bad = good;
    for (int i = 0; i < 4; ++i)
      bad[48 + static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
    // A length of 67 is padded to the true one.
    EXPECT_EQ(code_of(decode_message(two, bad)),
              value == 67 ? Code::tag_mismatch : Code::secure_group_malformed)
        << value;
  }
  for (const std::size_t at : {22u, 46u, 120u})
    for (const std::uint16_t value : {1, 3, 4, 19, 21, 0x7fff, 0x8000, 0xfffc, 0xffff}) {
      auto bad = good;
      bad[at] = static_cast<std::uint8_t>(value), bad[at + 1] = value >> 8;
      EXPECT_EQ(code_of(decode_message(two, bad)), Code::secure_group_malformed) << at;
    }
}

// Token octets of a hostile authenticated peer, with any size and any lengths (Fast DDS issue
// 6345).
TEST(ForgedTokens, TokensOfAnySizeAndContent_AreRefused) {
  TwoSides two(kEncrypt);
  SeededRandom random(27);
  for (std::size_t size = 0; size <= 300; ++size)
    for (int attempt = 0; attempt < 20; ++attempt) {
      auto token = crypto_token(KeyMaterial{});
      auto& octets = token.binary_properties.front().value;
      octets.assign(size, attempt == 0 ? 0xff : 0x00);
      if (attempt > 1) random.fill(octets).value();
      if (attempt > 2 && size > 8) octets[0] = octets[1] = octets[2] = 0, octets[3] = 4;
      if (attempt > 3 && size > 8) octets[4] = octets[5] = octets[6] = 0, octets[7] = 32;
      EXPECT_THAT(code_of(two.take_participant({&token, 1})),
                  ::testing::AnyOf(Code::key_material_length, Code::key_material_kind_unknown,
                                   Code::key_material_kind_mismatch, Code::key_material_all_zero,
                                   Code::key_material_key_id, Code::receiver_specific_key_missing))
          << size;
    }
  EXPECT_TRUE(decode_message(two, encode_message(two, rtps_message({data_submessage(8)})).value()));
}

}  // namespace
}  // namespace ddssec::cryptography::testing
