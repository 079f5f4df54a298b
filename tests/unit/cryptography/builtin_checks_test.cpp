#include "plugins/cryptography/builtin_checks.hpp"

#include <gtest/gtest.h>

#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography {
namespace {

using namespace testing;

constexpr std::uint16_t kParticipantGuid = 0x50, kEndpointGuid = 0x5a, kKeyHash = 0x70,
                        kTopicGuid = 0x801b, kTopicName = 0x05;
constexpr EntityId kParticipantWriters[] = {{{0, 1, 0, 0xc2}}, {{0xff, 1, 1, 0xc2}}};
constexpr EntityId kEndpointWriters[] = {
    {{0, 0, 3, 0xc2}}, {{0xff, 0, 3, 0xc2}}, {{0, 0, 4, 0xc2}}, {{0xff, 0, 4, 0xc2}}};
constexpr EntityId kLivelinessWriters[] = {{{0, 2, 0, 0xc2}}, {{0xff, 2, 0, 0xc2}}};
constexpr EntityId kTopicWriter{{0, 0, 2, 0xc2}};
constexpr std::uint8_t kData = 0x04, kKey = 0x08, kInlineQos = 0x02;

Bytes guid_of(const GuidPrefix& prefix) {
  auto out = to_bytes(prefix.view());
  append(out, Bytes{0, 0, 1, 3});
  return out;
}

struct Named {
  std::uint16_t id;
  Bytes value;
};
void append_parameter(Bytes& out, const Named& one, bool little) {
  append(out, one.id, 2, little);
  append(out, one.value.size(), 2, little);
  append(out, one.value);
}
// Returns a parameter list with a string before these parameters, and a sentinel.
Bytes list(std::initializer_list<Named> named, bool little) {
  Bytes out = {0, static_cast<std::uint8_t>(little ? 3 : 2), 0, 0};
  append_parameter(out, {kTopicName, Bytes(12, 0x50)}, little);
  for (const auto& one : named) append_parameter(out, one, little);
  append_parameter(out, {1, {}}, little);
  return out;
}
Bytes inline_qos(const Named& one, bool little) {
  Bytes out;
  append_parameter(out, {0x71, Bytes(4, 3)}, little);
  append_parameter(out, one, little);
  append_parameter(out, {1, {}}, little);
  return out;
}
// Returns ParticipantMessageData.
Bytes liveliness(const GuidPrefix& prefix, std::uint8_t encoding) {
  Bytes out = {0, encoding, 0, 0};
  append(out, prefix.view());
  append(out, Bytes{0, 0, 0, 1, 0, 0, 0, 0});
  return out;
}

Result<TypeInformationAt> check(BytesView octets) {
  OneOwner walks;
  return check_builtin_source(octets, kPeer, walks);
}
Code code(const DataMessage& message) { return code_of(check(message.octets())); }

// Calls `f` for both byte orders, as data and as a key. The payload may have another order than its
// submessage.
template <class F>
void each_form(F&& f) {
  for (const bool little : {false, true})
    for (const bool payload_little : {false, true})
      for (const auto flags : {kData, kKey}) f(little, payload_little, flags);
}

TEST(BuiltinSource, OwnersOwnSource_Passes) {
  each_form([](bool little, bool order, std::uint8_t flags) {
    DataMessage message{.little = little, .flags = flags};
    for (const auto& writer : kParticipantWriters) {
      message.writer = writer;
      message.payload = list({{kParticipantGuid, guid_of(kPeer)}}, order);
      EXPECT_EQ(code(message), Code{});
    }
    for (const auto& writer : kEndpointWriters) {
      message.writer = writer;
      message.payload =
          list({{kParticipantGuid, guid_of(kPeer)}, {kEndpointGuid, guid_of(kPeer)}}, order);
      EXPECT_EQ(code(message), Code{});
      message.payload = list({{kKeyHash, guid_of(kPeer)}}, order);  // a key in the form of Fast DDS
      EXPECT_EQ(code(message), Code{});
    }
    for (const auto& writer : kLivelinessWriters) {
      message.writer = writer;
      message.payload = liveliness(kPeer, order ? 1 : 0);
      EXPECT_EQ(code(message), Code{});
      message.payload[1] = order ? 3 : 2;  // the form of Fast DDS
      EXPECT_EQ(code(message), Code{});
    }
    message.writer = kTopicWriter;
    message.payload = list({{kTopicGuid, guid_of(kPeer)}}, order);
    EXPECT_EQ(code(message), Code{});
  });
}

TEST(BuiltinSource, AnotherSource_IsRefusedWhereverItStands) {
  each_form([](bool little, bool order, std::uint8_t flags) {
    DataMessage message{.little = little, .flags = flags};
    const Named own{kEndpointGuid, guid_of(kPeer)};
    for (const auto& writer : kEndpointWriters) {
      message.writer = writer;
      for (const auto id : {kEndpointGuid, kParticipantGuid, kKeyHash}) {
        const Named others{id, guid_of(kVictim)};
        message.payload = list({own, others}, order);
        EXPECT_EQ(code(message), Code::builtin_source_mismatch) << id;
        message.payload = list({others, own}, order);
        EXPECT_EQ(code(message), Code::builtin_source_mismatch) << id;
      }
    }
    for (const auto& writer : kParticipantWriters) {
      message.writer = writer;
      message.payload = list({{kParticipantGuid, guid_of(kVictim)}}, order);
      EXPECT_EQ(code(message), Code::builtin_source_mismatch);
    }
    for (const auto& writer : kLivelinessWriters) {
      message.writer = writer;
      message.payload = liveliness(kVictim, order ? 1 : 0);
      EXPECT_EQ(code(message), Code::builtin_source_mismatch);
    }
    message.writer = kTopicWriter;
    message.payload = list({{kTopicGuid, guid_of(kVictim)}}, order);
    EXPECT_EQ(code(message), Code::builtin_source_mismatch);
  });
}

TEST(BuiltinSource, TheError_NamesBothAndTheWriter) {
  const DataMessage message{.writer = kEndpointWriters[1],
                            .payload = list({{kEndpointGuid, guid_of(kVictim)}}, true)};
  const auto status = check(message.octets());
  ASSERT_EQ(code_of(status), Code::builtin_source_mismatch);
  EXPECT_EQ(status.error().details().expected, kPeer.to_string());
  EXPECT_EQ(status.error().details().found, kVictim.to_string());
  EXPECT_EQ(status.error().details().field, "PID_ENDPOINT_GUID");
  EXPECT_NE(status.error().to_sentence().find("ff0003c2"), std::string::npos);
}

TEST(BuiltinSource, EachOctetOfThePrefix_Counts) {
  for (std::size_t at = 0; at < GuidPrefix::size; ++at) {
    auto other = kPeer;
    other.octets[at] ^= 1;
    EXPECT_EQ(code({.writer = kEndpointWriters[1],
                    .payload = list({{kEndpointGuid, guid_of(other)}}, true)}),
              Code::builtin_source_mismatch);
    EXPECT_EQ(code({.writer = kLivelinessWriters[1], .payload = liveliness(other, 1)}),
              Code::builtin_source_mismatch);
  }
}

TEST(BuiltinSource, InlineQos_CountsToo) {
  for (const bool little : {false, true}) {
    for (const auto& writer :
         {kEndpointWriters[1], kParticipantWriters[1], kLivelinessWriters[1]}) {
      DataMessage message{.little = little,
                          .writer = writer,
                          .flags = kInlineQos,
                          .inline_qos = inline_qos({kKeyHash, guid_of(kPeer)}, little),
                          .payload = {}};
      EXPECT_EQ(code(message), Code{});
      message.inline_qos = inline_qos({kKeyHash, guid_of(kVictim)}, little);
      EXPECT_EQ(code(message), Code::builtin_source_mismatch);
      message.inline_qos = inline_qos({kKeyHash, Bytes(8, 1)}, little);
      EXPECT_EQ(code(message), Code::builtin_source_unreadable);
    }
  }
}

TEST(BuiltinSource, ListCutOffAnywhere_IsRefused) {
  for (const auto& writer : {kEndpointWriters[1], kParticipantWriters[0]}) {
    const auto id = writer == kEndpointWriters[1] ? kEndpointGuid : kParticipantGuid;
    const DataMessage message{.writer = writer, .payload = list({{id, guid_of(kPeer)}}, true)};
    const auto whole = message.octets();
    for (std::size_t size = 16; size < whole.size(); ++size)
      EXPECT_EQ(code_of(check(BytesView(whole).first(size))), Code::builtin_source_unreadable)
          << size;
  }
  const DataMessage message{.writer = kLivelinessWriters[0], .payload = liveliness(kPeer, 1)};
  const auto whole = message.octets();
  for (std::size_t size = 16; size < 24 + 16; ++size)
    EXPECT_EQ(code_of(check(BytesView(whole).first(size))), Code::builtin_source_unreadable)
        << size;
}

TEST(BuiltinSource, UnreadableList_IsRefused) {
  const auto refused = [](const DataMessage& message) {
    return code(message) == Code::builtin_source_unreadable;
  };
  const auto writer = kEndpointWriters[1];
  const Named own{kEndpointGuid, guid_of(kPeer)};
  for (const std::uint8_t encoding : {0, 1, 6, 7, 8, 9, 10, 11, 0x83}) {
    auto payload = list({own}, true);
    payload[1] = encoding;
    EXPECT_TRUE(refused({.writer = writer, .payload = payload})) << int{encoding};
    payload[0] = 1;
    EXPECT_TRUE(refused({.writer = writer, .payload = payload}));
  }
  EXPECT_TRUE(refused({.writer = kLivelinessWriters[1], .payload = liveliness(kPeer, 6)}));
  EXPECT_TRUE(refused({.writer = writer, .payload = list({}, true)}));
  EXPECT_TRUE(refused({.writer = writer, .payload = list({{kEndpointGuid, Bytes(8, 1)}}, true)}));
  EXPECT_TRUE(refused({.writer = writer, .payload = list({{kTopicName, Bytes(6, 1)}, own}, true)}));
  EXPECT_TRUE(refused({.writer = writer, .to_inline_qos = 12, .payload = list({own}, true)}));
}

TEST(BuiltinSource, LivelinessInParts_IsRefused) {
  DataMessage message{.writer = kLivelinessWriters[1],
                      .flags = 0,
                      .payload = liveliness(kPeer, 1),
                      .fragment = Fragment{.size = 24, .whole = 24}};
  EXPECT_EQ(code(message), Code{});
  message.payload = liveliness(kVictim, 1);
  EXPECT_EQ(code(message), Code::builtin_source_mismatch);
  message.payload = liveliness(kPeer, 1);
  message.fragment->size = 16;
  EXPECT_EQ(code(message), Code::builtin_source_unreadable);
}

TEST(BuiltinSource, OtherWritersAndSubmessages_Pass) {
  EXPECT_EQ(code({.writer = {{0, 0, 1, 3}}, .payload = Bytes(40, 1)}), Code{});
  EXPECT_EQ(code({.writer = {{0, 0, 1, 2}}, .payload = Bytes(40, 1)}), Code{});
  EXPECT_EQ(code({.writer = {{0, 2, 1, 0xc3}}, .payload = Bytes(40, 1)}), Code{});
  EXPECT_TRUE(check(data_submessage(28, submessage_id::kHeartbeat)));
  EXPECT_TRUE(check(Bytes{0x15, 1, 0, 0}));
}

// ---- within a protected message

Bytes info_source(const GuidPrefix& prefix) {
  Bytes out = {submessage_id::kInfoSource, 1, 20, 0, 0, 0, 0, 0, 2, 1, 1, 16};
  append(out, prefix.view());
  return out;
}

TEST(BuiltinSource, SourceInAProtectedMessage_IsThatOfTheLastInfoSource) {
  OneOwner walks;
  constexpr GuidPrefix kSibling{{0x81, 2, 3, 4, 5, 6, 70, 80, 90, 100, 110, 120}};
  const auto own = DataMessage{.writer = kLivelinessWriters[0], .payload = liveliness(kPeer, 1)};
  const auto siblings =
      DataMessage{.writer = kLivelinessWriters[0], .payload = liveliness(kSibling, 1)};
  auto content = info_source(kPeer);
  append(content, own.octets());
  const auto first = content.size();
  append(content, info_source(kSibling));
  append(content, siblings.octets());
  EXPECT_EQ(part_of_sender(content, kPeer, walks).size, content.size());
  const auto whole = content.size();
  append(content, own.octets());  // sent by a sibling
  const auto part = part_of_sender(content, kPeer, walks);
  EXPECT_EQ(part.size, whole);
  ASSERT_TRUE(part.ended);
  EXPECT_EQ(part.ended->code(), Code::builtin_source_mismatch);
  content.resize(first);
  append(content, siblings.octets());
  EXPECT_EQ(part_of_sender(content, kPeer, walks).size, first);
}

// ---- in the plugin

struct Receiver {
  explicit Receiver(bool host_checks, bool peer_is_known = true)
      : two(ProtectionKind::none, {}, {.host_checks_sources = host_checks}) {
    auto secret = shared_secret(5);
    if (peer_is_known) secret.peer_prefix = kPeer;
    for (auto* side : {&two.a, &two.b})
      side->remote = side->factory()
                         .register_matched_remote_participant(side->participant, {8}, {7}, secret)
                         .value();
    auto attributes = endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none);
    attributes.is_builtin = true;
    ends = two.endpoints(attributes);
  }
  Result<Bytes> pass(const DataMessage& message) {
    return decode_submessage(two, ends, encode_submessage(two, ends, message.octets()).value());
  }
  TwoSides two;
  WriterToReader ends;
};

DataMessage dispose(const GuidPrefix& whose) {
  return {.writer = kEndpointWriters[1],
          .flags = kKey | kInlineQos,
          .inline_qos = inline_qos({0x71, Bytes(4, 3)}, true),
          .payload = list({{kEndpointGuid, guid_of(whose)}}, true)};
}

TEST(TrustingHost, DiscoveryOfThePeer_PassesAndOfOthersDoesNot) {
  Receiver receiver(false);
  EXPECT_TRUE(receiver.pass(dispose(kPeer)));
  EXPECT_TRUE(receiver.two.b.events.codes().empty());
  EXPECT_EQ(code_of(receiver.pass(dispose(kVictim))), Code::builtin_source_mismatch);
  EXPECT_EQ(receiver.two.b.events.codes(), std::vector{Code::builtin_source_mismatch});
  EXPECT_NE(receiver.two.b.events.last().find(kVictim.to_string()), std::string::npos);
}

TEST(TrustingHost, UnknownPeerGuid_AllowsAnyName) {
  Receiver receiver(false, false);
  EXPECT_TRUE(receiver.pass(dispose(kVictim)));
}

TEST(CheckingHost, EveryProtectedName_PassesToAHostThatChecks) {
  Receiver receiver(true);
  EXPECT_TRUE(receiver.pass(dispose(kVictim)));
  EXPECT_TRUE(receiver.two.b.events.codes().empty());
}

// ---- addresses in the form of RTPS 1, for which Cyclone DDS frees memory that it never wrote

constexpr EntityId kUserWriter{{0, 0, 1, 0x02}};

Bytes address_qos(std::uint16_t id, bool little) {
  Bytes out;
  append_parameter(out, {0x71, Bytes(4, 0)}, little);
  append_parameter(out, {id, Bytes(4, 127)}, little);
  append_parameter(out, {1, {}}, little);
  return out;
}

TEST(DeprecatedAddresses, InlineQosOfAnyWriter_IsRefused) {
  for (const bool little : {true, false})
    for (const std::uint16_t id : {0x0b, 0x0c, 0x0d, 0x0e, 0x11, 0x45, 0x46}) {
      DataMessage message{.little = little,
                          .writer = kUserWriter,
                          .flags = kData | kInlineQos,
                          .inline_qos = address_qos(id, little)};
      EXPECT_EQ(code(message), Code::inline_qos_refused) << id;
      message.fragment = Fragment{};
      message.flags = kInlineQos;
      EXPECT_EQ(code(message), Code::inline_qos_refused) << id;
      message.fragment.reset();
      message.flags = kInlineQos;  // neither data nor a key
      EXPECT_EQ(code(message), Code::inline_qos_refused) << id;
      message.writer = kTokenWriter;
      EXPECT_EQ(code(message), Code::inline_qos_refused) << id;
      message.writer = kEndpointWriters[1];
      EXPECT_EQ(code(message), Code::builtin_source_unreadable) << id;
      message.writer = kLivelinessWriters[1];
      EXPECT_EQ(code(message), Code::builtin_source_unreadable) << id;
    }
}

TEST(DeprecatedAddresses, LivelinessOfAnUnknownOwner_IsRefusedToo) {
  OneOwner walks;
  const DataMessage message{.writer = kLivelinessWriters[0],
                            .flags = kData | kInlineQos,
                            .inline_qos = address_qos(0x0c, true),
                            .payload = liveliness(kPeer, 1)};
  EXPECT_EQ(code_of(check_builtin_source(message.octets(), {}, walks)), Code::inline_qos_refused);
}

TEST(DeprecatedAddresses, OtherInlineQosOfUserData_Passes) {
  for (const bool little : {true, false}) {
    DataMessage message{.little = little,
                        .writer = kUserWriter,
                        .flags = kData | kInlineQos,
                        .inline_qos = address_qos(kTopicName, little)};
    EXPECT_EQ(code(message), Code{});
    message.inline_qos.resize(message.inline_qos.size() - 4);
    message.payload = {};
    EXPECT_EQ(code(message), Code::inline_qos_refused) << "there is no sentinel";
    message.flags = kData;
    EXPECT_EQ(code(message), Code{}) << "there is no inline QoS";
  }
}

}  // namespace
}  // namespace ddssec::cryptography
