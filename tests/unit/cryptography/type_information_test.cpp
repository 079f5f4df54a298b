// PID_TYPE_INFORMATION is found wherever it stands, so that Cyclone DDS never reads it.
#include "plugins/cryptography/type_information.hpp"

#include <gtest/gtest.h>

#include "plugins/cryptography/builtin_checks.hpp"
#include "plugins/cryptography/sender_part.hpp"
#include "plugins/spi/property_names.hpp"
#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/insider.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography {
namespace {

using namespace testing;

constexpr EntityId kPublications{{0xff, 0, 3, 0xc2}};
constexpr EntityId kListWriters[] = {
    {{0, 1, 0, 0xc2}}, {{0xff, 1, 1, 0xc2}}, {{0, 0, 3, 0xc2}}, {{0xff, 0, 3, 0xc2}},
    {{0, 0, 4, 0xc2}}, {{0xff, 0, 4, 0xc2}}, {{0, 0, 2, 0xc2}}};
constexpr std::uint16_t kTypeInformation = 0x75, kTopicName = 0x05;

void append_parameter(Bytes& out, std::uint16_t id, BytesView value, bool little) {
  append(out, id, 2, little);
  append(out, value.size(), 2, little);
  append(out, value);
}

// Returns an announcement of the peer with these parameters before its names.
Bytes announcement(const std::vector<std::pair<std::uint16_t, Bytes>>& parameters, bool little,
                   const GuidPrefix& peer = kPeer) {
  auto guid = to_bytes(peer.view());
  append(guid, Bytes{0, 0, 1, 2});
  Bytes out = {0, static_cast<std::uint8_t>(little ? 3 : 2), 0, 0};
  for (const auto& [id, value] : parameters) append_parameter(out, id, value, little);
  for (const std::uint16_t id : {0x50, 0x5a, 0x801b}) append_parameter(out, id, guid, little);
  append_parameter(out, 1, {}, little);
  return out;
}

// Returns what a host gets of a submessage.
Result<Bytes> given(Bytes submessage, DiscoveryOfPeers& walks) {
  DDSSEC_ASSIGN_OR_RETURN(const auto at, check_builtin_source(submessage, kPeer, walks));
  if (at) hide_type_information(submessage, *at);
  return submessage;
}

Result<Bytes> given(const EntityId& writer, const Bytes& payload, bool little = true) {
  OneOwner walks;
  return given(DataMessage{.little = little, .writer = writer, .payload = payload}.octets(), walks);
}

Bytes of_size(std::size_t octets) { return Bytes(octets, 0xf1); }

TEST(TypeInformation, EachWriterAndByteOrder_GetsPaddingInstead) {
  for (const bool little : {true, false})
    for (const bool message_little : {true, false})
      for (const auto& writer : kListWriters)
        for (const std::size_t size : {0, 4, 148, 32'000}) {
          const auto list = [&](std::uint16_t id) {
            return announcement({{kTopicName, Bytes(12, 0x50)}, {id, of_size(size)}}, little);
          };
          const auto wanted =
              DataMessage{.little = message_little, .writer = writer, .payload = list(0)}.octets();
          EXPECT_EQ(given(writer, list(kTypeInformation), message_little), wanted) << size;
        }
}

TEST(TypeInformation, OtherParameters_StayUnchanged) {
  for (const std::uint16_t id : {0x74, 0x76, 0x7500, 0x8075, 0x4075}) {
    const auto list = announcement({{id, of_size(8)}}, true);
    EXPECT_EQ(given(kPublications, list),
              (DataMessage{.writer = kPublications, .payload = list}.octets()));
  }
  // The same octets within another parameter are no parameter.
  const auto user_data = announcement({{0x2c, Bytes{0x75, 0, 4, 0, 0x75, 0, 4, 0}}}, true);
  EXPECT_EQ(given(kPublications, user_data),
            (DataMessage{.writer = kPublications, .payload = user_data}.octets()));
}

TEST(TypeInformation, SecondOccurrence_IsRefused) {
  const auto list =
      announcement({{kTypeInformation, of_size(8)}, {kTypeInformation, of_size(8)}}, true);
  const auto status = given(kPublications, list);
  ASSERT_EQ(code_of(status), Code::builtin_source_unreadable);
  EXPECT_NE(status.error().to_sentence().find("type information"), std::string::npos);
}

DataMessage fragment_of(const Bytes& sample, std::uint32_t number, std::uint16_t size) {
  const auto from = (number - 1) * std::size_t{size};
  const auto to = std::min(from + size, sample.size());
  return {.writer = kPublications,
          .flags = 0,
          .payload = Bytes(sample.begin() + static_cast<std::ptrdiff_t>(from),
                           sample.begin() + static_cast<std::ptrdiff_t>(to)),
          .fragment = Fragment{
              .first = number, .size = size, .whole = static_cast<std::uint32_t>(sample.size())}};
}

constexpr std::size_t kTypeInformationAt = 20;  // after a topic name of 12 octets

bool first_octet_ends_fragment(std::uint16_t size) { return (kTypeInformationAt + 1) % size == 0; }

// Expects that the host reads the id `wanted_id` in place of the type information, also when the
// fragments arrive again.
void expect_hidden_in_fragments(bool little, std::uint16_t size, std::uint16_t wanted_id) {
  const auto list = [&](std::uint16_t id) {
    return announcement({{kTopicName, Bytes(12, 0x50)}, {id, of_size(40)}}, little);
  };
  const auto sample = list(kTypeInformation), wanted = list(wanted_id);
  OneOwner walks;
  const auto count = static_cast<std::uint32_t>((sample.size() + size - 1) / size);
  for (int round = 0; round < 2; ++round)
    for (std::uint32_t one = 1; one <= count; ++one)
      EXPECT_EQ(given(fragment_of(sample, one, size).octets(), walks),
                fragment_of(wanted, one, size).octets())
          << size << " " << one;
}

TEST(TypeInformation, InformationInFragmentsOfEachSize_IsHiddenAlsoWhenTheyComeAgain) {
  for (const bool little : {true, false})
    for (std::uint16_t size = 4; size < 128; ++size)
      if (!first_octet_ends_fragment(size)) expect_hidden_in_fragments(little, size, 0);
}

// The host has the first octet before the plugin knows the id, so the plugin turns it into an id
// that no host knows.
TEST(TypeInformation, InformationWhoseIdBeginsInTwoFragments_BecomesUnknown) {
  for (const bool little : {true, false})
    for (std::uint16_t size = 1; size <= kTypeInformationAt + 1; ++size)
      if (first_octet_ends_fragment(size))
        expect_hidden_in_fragments(little, size, little ? 0x8075 : 0);
}

// ---- in the plugin

// The source in the header of rtps_message.
constexpr GuidPrefix kSender{{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};

struct Receiver {
  explicit Receiver(spi::PropertyList properties = {}, bool peer_is_known = true)
      : two(ProtectionKind::encrypt, std::move(properties), {.host_checks_sources = false}) {
    auto secret = shared_secret(5);
    if (peer_is_known) secret.peer_prefix = kSender;
    for (auto* side : {&two.a, &two.b})
      side->remote = side->factory()
                         .register_matched_remote_participant(side->participant, {8}, {7}, secret)
                         .value();
    two.exchange_participant_tokens();
  }
  TwoSides two;
};

Bytes publication(std::uint16_t type_id) {
  return DataMessage{.writer = kPublications,
                     .payload = announcement({{type_id, of_size(8)}}, true, kSender)}
      .octets();
}

EndpointSecurityAttributes builtin(ProtectionKind kind) {
  auto attributes = endpoint_attributes(kind, ProtectionKind::none);
  attributes.is_builtin = true;
  return attributes;
}

TEST(TrustingHost, SecureWritersTypeInformation_IsHidden) {
  for (const auto kind : {ProtectionKind::sign, ProtectionKind::encrypt,
                          ProtectionKind::encrypt_with_origin_authentication})
    for (const bool is_known : {true, false}) {
      Receiver receiver({}, is_known);
      const auto ends = receiver.two.endpoints(builtin(kind));
      const auto encoded = encode_submessage(receiver.two, ends, publication(kTypeInformation));
      EXPECT_EQ(decode_submessage(receiver.two, ends, *encoded), publication(0));
      EXPECT_TRUE(receiver.two.b.events.codes().empty());
    }
}

// Returns what follows INFO_SRC in a message as the host gets it.
Bytes opened(Receiver& receiver, std::initializer_list<Bytes> submessages) {
  constexpr std::size_t kBegin = 20 + 24;
  const auto encoded = encode_message(receiver.two, rtps_message(submessages));
  const auto message = decode_message(receiver.two, *encoded).value();
  return {message.begin() + kBegin, message.end()};
}

TEST(TrustingHost, ClearTypeInformationWithinAMessage_IsHidden) {
  Receiver receiver;
  const auto padded = opened(receiver, {data_submessage(16), publication(kTypeInformation),
                                        publication(kTypeInformation)});
  Bytes wanted = data_submessage(16);
  for (int i = 0; i < 2; ++i) append(wanted, publication(0));
  EXPECT_EQ(padded, wanted);
}

// If the plugin changed the group before its own key was checked, the group would be refused, and
// with it every announcement.
TEST(TrustingHost, SignedGroupsWithinAMessage_PassUnchanged) {
  Receiver receiver;
  const auto ends = receiver.two.endpoints(builtin(ProtectionKind::sign));
  const auto group = encode_submessage(receiver.two, ends, publication(kTypeInformation)).value();
  const auto message = opened(receiver, {group, publication(kTypeInformation)});
  ASSERT_EQ(Bytes(message.begin(), message.begin() + static_cast<std::ptrdiff_t>(group.size())),
            group);
  EXPECT_EQ(decode_submessage(receiver.two, ends, group), publication(0));
  EXPECT_EQ(Bytes(message.begin() + static_cast<std::ptrdiff_t>(group.size()), message.end()),
            publication(0));
}

// Only a group that ends with SEC_POSTFIX has a key of its own.
TEST(SenderPart, TypeInformationAfterSecPrefixAlone_IsHidden) {
  const Bytes prefix = {0x31, 1, 4, 0, 0, 0, 0, 0}, postfix = {0x32, 1, 4, 0, 0, 0, 0, 0};
  OneOwner walks;
  for (const bool has_postfix : {true, false}) {
    auto content = prefix;
    append(content, publication(kTypeInformation));
    append(content, has_postfix ? postfix : data_submessage(8));
    const auto part = part_of_sender(content, kSender, walks);
    EXPECT_EQ(part.size, content.size());
    EXPECT_EQ(part.types.empty(), has_postfix);
  }
  EXPECT_EQ(part_of_sender(publication(kTypeInformation), kSender, walks).types.size(), 1u);
}

// Returns a message whose last submessage goes on to the end of the message. Our encoders write
// none.
Bytes opened_to_the_end(Receiver& receiver, const Bytes& first, Bytes last) {
  constexpr std::size_t kInfoSource = 24;
  last[2] = last[3] = 0;
  Insider sender(read_crypto_token(receiver.two.participant_tokens().value()[0]).value());
  auto message = rtps_message({});
  Bytes content = {submessage_id::kInfoSource, 1, 20, 0, 0, 0, 0, 0};
  content.insert(content.end(), message.begin() + 4, message.end());
  append(content, first);
  append(content, last);
  append(message, sender.group(kMessageFrame, content));
  const auto out = decode_message(receiver.two, message).value();
  return {out.begin() + 20 + kInfoSource, out.end()};
}

// Padding of length 0 would be empty to the host, which would read on within it.
TEST(TrustingHost, HiddenSubmessageToTheEnd_IsCutOff) {
  constexpr EntityId kTypeRequests{{0x00, 0x03, 0x00, 0xc3}};
  const auto first = data_submessage(16);
  const auto request = DataMessage{.writer = kTypeRequests, .reader = {}}.octets();
  Receiver receiver;
  EXPECT_EQ(opened_to_the_end(receiver, first, request), first);
  EXPECT_EQ(opened_to_the_end(receiver, first, fragment_of(Bytes(4000), 2, 1000).octets()), first);
}

TEST(TrustingHost, TypeInformation_PassesIfTheParticipantTrustsIt) {
  constexpr auto kName = spi::property::kTrustTypeInformation;
  for (const char* const value : {"true", "false"}) {
    const bool trusts = std::string_view(value) == "true";
    Receiver receiver({{std::string(kName), value, false}});
    const auto wanted = publication(trusts ? kTypeInformation : 0);
    const auto ends = receiver.two.endpoints(builtin(ProtectionKind::encrypt));
    const auto encoded = encode_submessage(receiver.two, ends, publication(kTypeInformation));
    EXPECT_EQ(decode_submessage(receiver.two, ends, *encoded), wanted);
    EXPECT_EQ(opened(receiver, {publication(kTypeInformation)}), wanted);
  }
  Side side;
  const auto refused = side.factory().register_local_participant(
      {1}, {1}, {{std::string(kName), "yes", false}}, participant_attributes(ProtectionKind::none));
  EXPECT_EQ(code_of(refused), Code::invalid_property);
}

}  // namespace
}  // namespace ddssec::cryptography
