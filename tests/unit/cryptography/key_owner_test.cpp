#include "plugins/cryptography/key_owner.hpp"

#include <gtest/gtest.h>

#include "plugins/cryptography/entities.hpp"
#include "plugins/cryptography/key_material.hpp"
#include "plugins/cryptography/token_ledger.hpp"
#include "tests/unit/cryptography/insider.hpp"
#include "tests/unit/cryptography/two_sides.hpp"
#include "wire/submessage_layout.hpp"

namespace ddssec::cryptography {
namespace {

using namespace testing;

constexpr CryptographyOptions kTrustingHost{.host_checks_sources = false};
constexpr GuidPrefix kPeer{{0x81, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};
constexpr EntityId kTokenWriter{{0xff, 0x02, 0x02, 0xc3}};
constexpr EntityId kTokenReader{{0xff, 0x02, 0x02, 0xc4}};
constexpr EntityId kSquare{{0, 0, 1, 0x03}}, kOther{{0, 0, 2, 0x03}}, kReader{{0, 0, 3, 0x04}};
constexpr EntityId kSecureLiveliness{{0xff, 0x02, 0x00, 0xc2}};

// Writes CDR in either byte order.
class Writer {
 public:
  explicit Writer(bool little) : little_(little) {}
  Writer& u32(std::uint32_t value) {
    out.resize((out.size() + 3) / 4 * 4);
    for (std::size_t i = 0; i < 4; ++i)
      out.push_back(static_cast<std::uint8_t>(value >> (8 * (little_ ? i : 3 - i))));
    return *this;
  }
  Writer& octets(BytesView view) {
    out.insert(out.end(), view.begin(), view.end());
    return *this;
  }
  Writer& text(std::string_view text) {
    u32(static_cast<std::uint32_t>(text.size() + 1)).octets(as_bytes(text));
    out.push_back(0);
    return *this;
  }
  Bytes out;

 private:
  bool little_;
};

// Returns a ParticipantGenericMessage with its encapsulation header.
Bytes token_message(const GuidPrefix& prefix, const EntityId& endpoint,
                    std::span<const spi::Token> tokens, bool little = true) {
  Writer cdr(little);
  cdr.octets(kPeer.view());
  cdr.out.resize(80, 0x11);
  const bool is_of_reader = endpoint == kReader;
  cdr.out.back() = is_of_reader ? 0x03 : 0x04;  // the kind of endpoint that they are for
  cdr.octets(prefix.view()).octets(endpoint.view());
  cdr.text(is_of_reader ? "dds.sec.datareader_crypto_tokens" : "dds.sec.datawriter_crypto_tokens");
  cdr.u32(static_cast<std::uint32_t>(tokens.size()));
  for (const auto& token : tokens) {
    cdr.text(token.class_id).u32(0).u32(1).text(token.binary_properties[0].name);
    const auto& value = token.binary_properties[0].value;
    cdr.u32(static_cast<std::uint32_t>(value.size())).octets(value);
  }
  Bytes out = {0, static_cast<std::uint8_t>(little ? 1 : 0), 0, 0};
  out.insert(out.end(), cdr.out.begin(), cdr.out.end());
  out.resize((out.size() + 3) / 4 * 4);
  return out;
}

// Returns a submessage of `size` octets in all that names `entity` at that place.
Bytes naming(std::uint8_t id, std::size_t at, const EntityId& entity, std::size_t size = 48) {
  auto out = data_submessage(size - 4, id);
  std::ranges::copy(entity.octets, out.begin() + static_cast<std::ptrdiff_t>(at));
  return out;
}
Bytes data_of(const EntityId& writer) { return naming(submessage_id::kData, 12, writer); }

// Returns a key token message as the key exchange protects it.
Bytes token_submessage(const EntityId& owner, std::span<const spi::Token> tokens) {
  auto out = naming(submessage_id::kData, 12, kTokenWriter, 24);
  constexpr EntityId kTokenReader{{0xff, 0x02, 0x02, 0xc4}};
  std::ranges::copy(kTokenReader.octets, out.begin() + 8);
  out[6] = 16, out[7] = 0;  // octetsToInlineQos
  std::fill(out.begin() + 16, out.begin() + 24, std::uint8_t{0});
  static std::uint8_t number = 0;
  out[20] = ++number;  // writerSN
  const auto payload = token_message(kPeer, owner, tokens);
  out.insert(out.end(), payload.begin(), payload.end());
  out[2] = static_cast<std::uint8_t>(out.size() - 4);
  out[3] = static_cast<std::uint8_t>((out.size() - 4) >> 8);
  return out;
}

// Returns the tokens that the host passes on from such a message.
std::vector<spi::Token> tokens_in(const Bytes& submessage) {
  return read_token_message(read_data_piece(submessage).value()).value()->tokens;
}

struct KeyOwnerTest : ::testing::Test {
  explicit KeyOwnerTest(bool revises = false)
      : two(participant_attributes(ProtectionKind::none, revises), {}, kTrustingHost) {}

  static EndpointSecurityAttributes attributes(ProtectionKind kind = ProtectionKind::encrypt) {
    return endpoint_attributes(kind, ProtectionKind::none);
  }
  // Passes the writer's tokens in a message from `owner`, and what the host then passes on.
  void take(const WriterToReader& ends, const EntityId& owner,
            spi::KeyStage stage = spi::KeyStage::in_use) {
    EXPECT_TRUE(take(ends, owner, two.writer_tokens(ends, stage).value()));
  }
  Status take(const WriterToReader& ends, const EntityId& owner,
              std::span<const spi::Token> tokens) {
    const auto passed = passes(exchange, token_submessage(owner, tokens));
    return two.take_writer(ends, tokens_in(passed.value()));
  }
  Result<Bytes> passes(const WriterToReader& ends, const Bytes& submessage) {
    return decode_submessage(two, ends, encode_submessage(two, ends, submessage).value());
  }

  TwoSides two;
  WriterToReader exchange = two.volatile_endpoints();
};

// One local reader, matched with a writer whose keys have not come.
struct UnknownOwner {
  Registry registry{1};
  RemoteParticipantCrypto peer{registry};
  LocalParticipantCrypto own;
  LocalEndpointCrypto reader{EntityKind::local_reader, own};
  RemoteEndpointCrypto writer{EntityKind::remote_writer, reader, peer};

  Code speak(const Bytes& plain) {
    const ReadGuard guard;
    return code_of(check_speaker(writer, plain));
  }
};

TEST(CheckSpeaker, UnknownOwner_MaySpeakForItsKindOfEndpointOnly) {
  for (const auto id : {submessage_id::kData, submessage_id::kDataFrag, submessage_id::kGap,
                        submessage_id::kHeartbeat, submessage_id::kHeartbeatFrag,
                        submessage_id::kAckNack, submessage_id::kNackFrag}) {
    const auto at = rtps::layout_of(SubmessageId{id})->sender_at();
    UnknownOwner sender;
    EXPECT_EQ(sender.speak(naming(id, at, kSquare)), Code{}) << int{id};
    EXPECT_EQ(sender.speak(naming(id, at, kSecureLiveliness)), Code::submessage_not_of_sender);
    sender.reader.is_builtin = true;
    EXPECT_EQ(sender.speak(naming(id, at, kSecureLiveliness)), Code{}) << int{id};
    EXPECT_EQ(sender.speak(naming(id, at, kSquare)), Code::submessage_not_of_sender);
  }
}

TEST(CheckSpeaker, CutSubmessage_IsRefused) {
  for (const auto id : {submessage_id::kData, submessage_id::kHeartbeat, submessage_id::kAckNack}) {
    const auto layout = *rtps::layout_of(SubmessageId{id});
    UnknownOwner sender;
    auto plain = naming(id, layout.sender_at(), kSquare);
    plain[2] = plain[3] = 0;  // the host reads on after the group
    for (std::size_t size = 4; size < layout.min_size; ++size)
      EXPECT_EQ(sender.speak(to_bytes(BytesView(plain).first(size))), Code::secure_group_malformed)
          << int{id} << " " << size;
    EXPECT_EQ(sender.speak(to_bytes(BytesView(plain).first(layout.min_size))), Code{});
  }
}

TEST_F(KeyOwnerTest, EndpointsKey_SpeaksForItsEndpointOnly) {
  for (const auto kind : {ProtectionKind::sign, ProtectionKind::encrypt,
                          ProtectionKind::encrypt_with_origin_authentication}) {
    const auto ends = two.endpoints(attributes(kind));
    take(ends, kSquare);
    for (const auto& [id, at] :
         {std::pair(submessage_id::kData, 12), std::pair(submessage_id::kDataFrag, 12),
          std::pair(submessage_id::kHeartbeat, 8), std::pair(submessage_id::kGap, 8),
          std::pair(submessage_id::kHeartbeatFrag, 8)}) {
      EXPECT_TRUE(passes(ends, naming(id, static_cast<std::size_t>(at), kSquare)));
      for (const auto& other : {kOther, kSecureLiveliness, EntityId{}, kEntityIdParticipant}) {
        const auto refused = passes(ends, naming(id, static_cast<std::size_t>(at), other));
        ASSERT_EQ(code_of(refused), Code::submessage_not_of_sender) << int{id};
        EXPECT_EQ(refused.error().details().expected, kSquare.to_string());
        EXPECT_EQ(refused.error().details().found, other.to_string());
      }
    }
    EXPECT_TRUE(passes(ends, naming(submessage_id::kInfoTimestamp, 4, kOther, 12)));
  }
}

TEST_F(KeyOwnerTest, EachOfAWritersReaders_KnowsIt) {
  const auto ends = two.endpoints(attributes());
  auto second = ends;
  second.reader =
      two.b.factory().register_local_datareader(two.b.participant, {}, attributes()).value();
  two.match_endpoints(second);
  take(ends, kSquare);
  take(second, kSquare);
  EXPECT_TRUE(passes(second, data_of(kSquare)));
  EXPECT_EQ(code_of(passes(second, data_of(kOther))), Code::submessage_not_of_sender);
  EXPECT_EQ(code_of(passes(ends, data_of(kOther))), Code::submessage_not_of_sender);
}

TEST_F(KeyOwnerTest, KeyWithoutAnOwner_SpeaksForItsKindOnly) {
  const auto ends = two.endpoints(attributes());
  EXPECT_TRUE(passes(ends, data_of(kSquare)));
  EXPECT_TRUE(passes(ends, data_of(kOther)));
  EXPECT_EQ(code_of(passes(ends, data_of(kSecureLiveliness))), Code::submessage_not_of_sender);
  auto builtin = attributes();
  builtin.is_builtin = true;
  const auto of_discovery = two.endpoints(builtin);
  EXPECT_TRUE(passes(of_discovery, data_of(kSecureLiveliness)));
  EXPECT_EQ(code_of(passes(of_discovery, data_of(kSquare))), Code::submessage_not_of_sender);
}

TEST_F(KeyOwnerTest, AReader_AcknowledgesAsItselfOnly) {
  const auto ends = two.endpoints(attributes());
  const auto tokens = two.reader_tokens(ends).value();
  // The same channel in the other direction.
  auto& b = two.b;
  auto& a = two.a;
  const auto channel = attributes();
  const auto writer = b.factory()
                          .register_local_datawriter(
                              b.participant, builtin_endpoint(testing::kVolatileWriter), channel)
                          .value();
  const auto reader = a.factory()
                          .register_local_datareader(
                              a.participant, builtin_endpoint(testing::kVolatileReader), channel)
                          .value();
  const auto to =
      b.factory().register_matched_remote_datareader(writer, b.remote, shared_secret(), false);
  const auto from =
      a.factory().register_matched_remote_datawriter(reader, a.remote, shared_secret());
  TwoSides::let_reader_speak(a, reader, *from);
  const auto message = token_submessage(kReader, tokens);
  const auto sent =
      into_bytes(message.size() + spi::protection_overhead(1), [&](MutableBytes out) {
        return b.transform().encode_datawriter_submessage(writer, {&*to, 1}, message, out);
      }).value();
  const auto passed = into_bytes(sent.size(), [&](MutableBytes out) {
    return a.transform().decode_datawriter_submessage(reader, *from, sent, out);
  });
  ASSERT_TRUE(two.take_reader(ends, tokens_in(passed.value())));
  const auto replies = [&](std::uint8_t id, const EntityId& as) {
    return decode_reply(two, ends, encode_reply(two, ends, naming(id, 4, as)).value());
  };
  for (const auto id : {submessage_id::kAckNack, submessage_id::kNackFrag}) {
    EXPECT_TRUE(replies(id, kReader));
    EXPECT_EQ(code_of(replies(id, kOther)), Code::submessage_not_of_sender);
  }
}

TEST_F(KeyOwnerTest, TheKeyExchange_SpeaksForItselfOnly) {
  const auto passes_exchange = [&](const Bytes& one) { return passes(exchange, one); };
  EXPECT_TRUE(passes_exchange(naming(submessage_id::kHeartbeat, 8, kTokenWriter)));
  EXPECT_TRUE(passes_exchange(naming(submessage_id::kAckNack, 4, kTokenReader)));
  EXPECT_EQ(code_of(passes_exchange(naming(submessage_id::kHeartbeat, 8, kSquare))),
            Code::submessage_not_of_sender);
  EXPECT_EQ(code_of(passes_exchange(naming(submessage_id::kAckNack, 4, kReader))),
            Code::submessage_not_of_sender);
}

TEST_F(KeyOwnerTest, KeyThatTwoEndpointsClaim_IsNotTaken) {
  const auto ends = two.endpoints(attributes());
  take(ends, kSquare);
  const auto tokens = two.writer_tokens(ends).value();
  EXPECT_EQ(code_of(take(ends, kOther, tokens)), Code::key_material_key_id);
  const auto other = two.endpoints(attributes());
  EXPECT_EQ(code_of(take(other, kOther, tokens)), Code::key_material_key_id);
  EXPECT_TRUE(passes(ends, data_of(kSquare)));  // tokens that were taken stay
  EXPECT_EQ(code_of(passes(ends, data_of(kOther))), Code::submessage_not_of_sender);
}

struct RevisedKeyOwnerTest : KeyOwnerTest {
  RevisedKeyOwnerTest() : KeyOwnerTest(true) {}
};

TEST_F(RevisedKeyOwnerTest, FormerAndLaterKeys_KeepTheirOwner) {
  const auto ends = two.endpoints(attributes());
  take(ends, kSquare);
  const auto before = encode_submessage(two, ends, data_of(kOther)).value();
  const auto revision = two.a.factory().revise_local_entity_keys(two.a.participant);
  ASSERT_TRUE(revision);
  // This holds even if the message with the revised tokens shows no owner.
  ASSERT_TRUE(two.take_writer(ends, two.writer_tokens(ends, spi::KeyStage::revised).value()));
  EXPECT_EQ(code_of(decode_submessage(two, ends, before)), Code::submessage_not_of_sender);
  ASSERT_TRUE(two.a.factory().activate_key_revision(two.a.participant, *revision));
  EXPECT_TRUE(passes(ends, data_of(kSquare)));
  EXPECT_EQ(code_of(passes(ends, data_of(kOther))), Code::submessage_not_of_sender);
  two.b.clock.advance(std::chrono::seconds(11));
  two.b.factory().forget_former_keys();
  EXPECT_EQ(code_of(passes(ends, data_of(kOther))), Code::submessage_not_of_sender);
}

TEST_F(KeyOwnerTest, ASubmessage_HasAllItsFields) {
  const auto ends = two.endpoints(attributes());
  take(ends, kSquare);
  Insider insider(read_crypto_token(two.writer_tokens(ends).value()[0]).value());
  const auto opens = [&](const Bytes& submessage) {
    return decode_submessage(two, ends, insider.group(kSubmessageFrame, submessage));
  };
  struct Case {
    std::uint8_t id;
    std::size_t at, fields;
  };
  for (const auto& [id, at, fields] :
       {Case{submessage_id::kData, 12, 24}, Case{submessage_id::kDataFrag, 12, 36},
        Case{submessage_id::kHeartbeat, 8, 32}, Case{submessage_id::kGap, 8, 32},
        Case{submessage_id::kHeartbeatFrag, 8, 28}}) {
    // If the length were 0, the host would read the rest of the fields from what follows the group.
    for (std::size_t size = 4; size <= fields; size += 4) {
      auto submessage = naming(id, at, kSquare, std::max(size, at + 4));
      submessage.resize(size);
      submessage[2] = submessage[3] = 0;
      EXPECT_EQ(code_of(opens(submessage)), size < fields ? Code::secure_group_malformed : Code{})
          << int{id} << " " << size;
    }
    EXPECT_EQ(code_of(opens(data_submessage(at - 4, id))), Code::secure_group_malformed);
  }
}

// An INFO_TS of length 0 is empty to the host, which would read the following submessages
// unchecked.
TEST_F(KeyOwnerTest, AnEmptySubmessage_HidesNone) {
  const auto ends = two.endpoints(attributes());
  take(ends, kSquare);
  Insider insider(read_crypto_token(two.writer_tokens(ends).value()[0]).value());
  const auto opens = [&](const Bytes& submessages) {
    return code_of(decode_submessage(two, ends, insider.group(kSubmessageFrame, submessages)));
  };
  Bytes submessages = {submessage_id::kInfoTimestamp, 1, 0, 0};
  EXPECT_EQ(opens(submessages), Code{});
  const auto further = data_of(kSquare);
  submessages.insert(submessages.end(), further.begin(), further.end());
  EXPECT_EQ(opens(submessages), Code::secure_group_malformed);
}

}  // namespace
}  // namespace ddssec::cryptography
