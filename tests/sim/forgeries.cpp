#include "tests/sim/forgeries.hpp"

#include "tests/unit/cryptography/insider.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "wire/data_frag.hpp"
#include "wire/gap.hpp"
#include "wire/info_source.hpp"
#include "wire/parameter_list.hpp"

namespace ddssec::rtps::sim {
namespace {

using testing::forged;

// Returns the parameters of a list in little-endian, with their headers, without the sentinel.
std::vector<BytesView> parameters_of(BytesView list) {
  std::vector<BytesView> out;
  ParameterReader reader(list, Endian::little);
  for (std::size_t at = 0;;) {
    const auto parameter = reader.next();
    if (!parameter || !*parameter) return out;
    out.push_back(list.subspan(at, reader.consumed() - at));
    at = reader.consumed();
  }
}

}  // namespace

std::vector<BytesView> submessages_of(BytesView datagram) {
  std::vector<BytesView> out;
  auto reader = MessageReader::open(datagram);
  while (reader) {
    const auto view = reader->next();
    if (!view || !*view) break;
    out.push_back((*view)->whole);
  }
  return out;
}

Bytes splice(BytesView one, BytesView other, Dice& dice) {
  if (one.size() < kHeaderSize) return to_bytes(other);
  auto parts = submessages_of(one);
  for (const auto& part : submessages_of(other))
    parts.insert(parts.begin() + static_cast<std::ptrdiff_t>(dice.below(parts.size() + 1)), part);
  if (dice.chance(300) && !parts.empty())
    parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(dice.below(parts.size())));
  auto out = to_bytes(one.first(kHeaderSize));
  for (const auto& part : parts) {
    if (out.size() + part.size() > 65'000) break;
    out.insert(out.end(), part.begin(), part.end());
  }
  return out;
}

Forger::Forger(const Ledger& ledger, const Invariants& invariants,
               std::span<const Datagram> recorded, Dice& dice)
    : ledger_(ledger), invariants_(invariants), recorded_(recorded), dice_(dice) {}

std::span<const Forger::Kind> Forger::kinds() {
  static constexpr std::array kKinds = {Kind{&Forger::stranger, 800},
                                        Kind{&Forger::false_address, 40},
                                        Kind{&Forger::false_announcement, 40},
                                        Kind{&Forger::dispose_announcement, 5},
                                        Kind{&Forger::endpoint, 200},
                                        Kind{&Forger::endpoint_end, 20},
                                        Kind{&Forger::sample, 20},
                                        Kind{&Forger::fragment, 20},
                                        Kind{&Forger::acknowledgement, 20},
                                        Kind{&Forger::horizon, 20},
                                        Kind{&Forger::handshake, 60},
                                        Kind{&Forger::question, 60},
                                        Kind{&Forger::handshake_fragment, 60},
                                        Kind{&Forger::keys, 10},
                                        Kind{&Forger::liveliness, 20},
                                        Kind{&Forger::other_time, 20},
                                        Kind{&Forger::other_destination, 20},
                                        Kind{&Forger::garbage, 20}};
  return kKinds;
}

std::vector<Forger::Forgery> Forger::burst(std::size_t nodes) {
  return burst_of(dice_.of(kinds()), nodes);
}

std::vector<Forger::Forgery> Forger::announcements(std::size_t nodes) {
  static constexpr std::array kAnnouncements = {Kind{&Forger::local_address, 10},
                                                Kind{&Forger::repeated_parameter, 10}};
  return burst_of(dice_.of(kAnnouncements), nodes);
}

std::vector<Forger::Forgery> Forger::crowd() {
  constexpr std::size_t kAtOnce = 10;
  std::vector<Forgery> out;
  for (std::size_t i = 0; i < kAtOnce; ++i) {
    auto data = member_in_a_new_name();
    data.lease_duration = kDurationInfinite;
    out.push_back({testing::announcement(data), Locator::udp_v4({192, 0, 2, 250}, 7400)});
  }
  return out;
}

std::vector<Forger::Forgery> Forger::burst_of(const Kind& kind, std::size_t nodes) {
  std::vector<Forgery> out;
  const auto count = 1 + dice_.below(kind.most);
  const auto one_source = address_of(dice_.below(nodes + 3));
  const bool many_sources = dice_.chance(300);
  for (std::size_t i = 0; i < count; ++i) {
    auto octets = (this->*kind.make)();
    if (octets.empty()) continue;
    const auto from = many_sources ? Locator::udp_v4({192, 0, 2, dice_.octet()}, 7400) : one_source;
    out.push_back(Forgery{std::move(octets), from});
  }
  return out;
}

GuidPrefix Forger::name() {
  const auto& lives = ledger_.lives();
  return std::next(lives.begin(), static_cast<std::ptrdiff_t>(dice_.below(lives.size())))->first;
}

Guid Forger::endpoint_guid(bool writes, const std::optional<GuidPrefix>& whose) {
  const auto& ends = invariants_.ends();
  for (int attempt = 0; attempt < (whose ? 100 : 20); ++attempt) {
    const auto at = std::next(ends.begin(), static_cast<std::ptrdiff_t>(dice_.below(ends.size())));
    const auto* life = ledger_.life(at->first.prefix);
    const bool lives = life != nullptr && life->died == kNever;
    const bool fits = whose ? at->first.prefix == *whose : lives || dice_.chance(100);
    if (at->second.writes == writes && fits) return at->first;
  }
  return {name(), writes ? EntityId{{0, 0, 1, 2}} : EntityId{{0, 0, 1, 7}}};
}

Bytes Forger::heard(const EntityId& writer) {
  for (int attempt = 0; attempt < 200; ++attempt) {
    auto reader = MessageReader::open(dice_.of(recorded_).octets);
    while (reader) {
      const auto view = reader->next();
      if (!view || !*view) break;
      if ((*view)->id != SubmessageId::data) continue;
      const auto data = read_data(**view);
      if (data && data->writer == writer && !data->payload.empty()) return to_bytes(data->payload);
    }
  }
  return {};
}

Bytes Forger::in_the_name_of_another() {
  constexpr std::array<Make, 4> kMakes = {&Forger::sample, &Forger::endpoint, &Forger::horizon,
                                          &Forger::acknowledgement};
  const auto datagram = (this->*dice_.of(kMakes))();
  InfoSource source;
  source.source.prefix = GuidPrefix::from(BytesView(datagram).subspan(8, 12));
  auto out = forged({}, source);
  out.insert(out.end(), datagram.begin() + kHeaderSize, datagram.end());
  return {out.begin() + kHeaderSize, out.end()};
}

ParticipantData Forger::member_in_a_new_name() {
  if (!member_)
    member_ = read_participant_data(heard(kSpdpWriter)).value_or(testing::secured_data({}));
  auto data = *member_;
  data.guid.prefix = GuidPrefix::from(dice_.octets(12));
  data.default_unicast.clear();
  data.metatraffic_unicast = {Locator::udp_v4({192, 0, 2, dice_.octet()}, 7400)};
  data.domain_tag = kTags[0];
  return data;
}

Bytes Forger::stranger() {
  auto data = member_in_a_new_name();
  if (dice_.chance(300)) data.user_data = dice_.octets(dice_.below(3000));
  if (dice_.chance(200)) data.lease_duration = kDurationInfinite;
  if (dice_.chance(100)) data.identity_token.reset();
  return testing::announcement(data);
}

Bytes Forger::changed_announcement(const std::function<void(ParticipantData&)>& change) {
  auto data = read_participant_data(heard(kSpdpWriter));
  if (!data) return {};
  change(*data);
  return testing::announcement(*data);
}

Bytes Forger::false_address() {
  return changed_announcement([&](ParticipantData& data) {
    const auto wrong = Locator::udp_v4({192, 0, 2, dice_.octet()}, 7400);
    data.metatraffic_unicast.assign(1 + dice_.below(4), wrong);
    if (dice_.chance(500)) data.default_unicast = {wrong};
  });
}

Bytes Forger::false_announcement() {
  return changed_announcement([&](ParticipantData& data) {
    switch (dice_.below(8)) {
      case 0:
        data.lease_duration = dice_.chance(500) ? kDurationInfinite : Duration{{0, 1}};
        break;
      case 1:
        data.domain_tag = dice_.of(kTags);
        break;
      case 2:
        data.builtin_endpoints = static_cast<std::uint32_t>(dice_.next());
        break;
      case 3:
        data.identity_token.reset();
        break;
      case 4:
        if (data.identity_token) data.identity_token->class_id += "x";
        break;
      case 5:
        data.domain_id = static_cast<std::uint32_t>(dice_.below(3));
        break;
      case 6:
        data.security_info.reset();
        break;
      default:
        data.user_data = dice_.octets(dice_.below(2000));
    }
  });
}

Bytes Forger::dispose_announcement() {
  Bytes buffer(64);
  SpanWriter out(buffer);
  out.write_bytes(Bytes{0, 3, 0, 0});
  const auto whose = name();
  write_participant_key(out, {whose, kEntityIdParticipant});
  Data data{kEntityIdUnknown, kSpdpWriter, {static_cast<std::int64_t>(1 + dice_.below(9))}};
  data.inline_qos.status = {.disposed = true, .unregistered = true};
  data.kind = PayloadKind::key;
  data.payload = out.view();
  return forged(whose, data);
}

Bytes Forger::endpoint() {
  const bool writes = dice_.chance(500);
  EndpointData data{.guid = endpoint_guid(writes)};
  if (dice_.chance(300)) data.guid.entity.octets[2] = dice_.octet();
  data.topic_name = dice_.of(kTopics);
  data.type_name = "ShapeType";
  data.qos = default_writer_qos();
  if (dice_.chance(300)) data.unicast = {Locator::udp_v4({192, 0, 2, 9}, 7400)};
  Bytes buffer(4096);
  SpanWriter out(buffer);
  write_payload(out, data);
  const auto number = static_cast<std::int64_t>(1 + dice_.below(dice_.chance(500) ? 10 : 2000));
  return forged(data.guid.prefix, Data{kEntityIdUnknown,
                                       writes ? kPublicationsWriter : kSubscriptionsWriter,
                                       {number},
                                       {},
                                       PayloadKind::data,
                                       out.view()});
}

Bytes Forger::endpoint_end() {
  const bool writes = dice_.chance(500);
  const auto guid = endpoint_guid(writes);
  Bytes buffer(64);
  SpanWriter out(buffer);
  out.write_bytes(Bytes{0, 3, 0, 0});
  write_endpoint_key(out, guid);
  const std::array writers = {kPublicationsWriter, kSubscriptionsWriter, kPublicationsSecureWriter,
                              kSubscriptionsSecureWriter};
  Data data{kEntityIdUnknown, dice_.of(writers), {static_cast<std::int64_t>(1 + dice_.below(30))}};
  data.inline_qos.status = {.disposed = true, .unregistered = true};
  data.kind = PayloadKind::key;
  data.payload = out.view();
  return forged(guid.prefix, data);
}

Bytes Forger::sample_by(const GuidPrefix& writer) { return sample_of(endpoint_guid(true, writer)); }

Bytes Forger::sample_of(const Guid& writer) {
  const auto later = dice_.chance(600) ? 0 : dice_.below(3);
  const auto number = ledger_.count(writer) + 1 + static_cast<std::int64_t>(later);
  auto octets = dice_.octets(8 + 4 * dice_.below(30));
  std::ranges::copy(Bytes{0, 1, 0, 0}, octets.begin());
  Data data{kEntityIdUnknown, writer.entity, {number}, {}, PayloadKind::data, octets};
  if (dice_.chance(300)) data.inline_qos.status = {.disposed = true};
  if (dice_.chance(200)) data.kind = PayloadKind::none, data.payload = {};
  if (dice_.chance(300)) data.inline_qos.original = {endpoint_guid(true), {number}};
  return forged(writer.prefix, data);
}

Bytes Forger::fragment() {
  const auto writer = endpoint_guid(true);
  const auto octets = dice_.octets(4 * (1 + dice_.below(300)));
  const auto size = static_cast<std::uint16_t>(octets.size());
  DataFrag frag{.reader = kEntityIdUnknown,
                .writer = writer.entity,
                .sequence_number = {ledger_.count(writer) + 1},
                .first = {static_cast<std::uint32_t>(1 + dice_.below(50'000))},
                .fragment_size = size,
                .sample_size = 64u << 20,
                .payload = octets};
  if (dice_.chance(500)) frag.fragment_size = 1, frag.count = size;
  return forged(writer.prefix, frag);
}

Bytes Forger::acknowledgement() {
  const auto writer = endpoint_guid(true), reader = endpoint_guid(false);
  const auto last = static_cast<std::size_t>(ledger_.count(writer));
  SequenceNumberSet missing({static_cast<std::int64_t>(dice_.below(last + 3))});
  for (std::int64_t i = 0; i < 20; ++i) missing.insert({missing.base().value + i});
  const AckNack acknack{.reader = reader.entity,
                        .writer = writer.entity,
                        .missing = missing,
                        .count = static_cast<std::int32_t>(dice_.next())};
  InfoDestination to;
  to.prefix = writer.prefix;
  return forged(reader.prefix, to, acknack);
}

Bytes Forger::horizon() {
  const auto writer = endpoint_guid(true);
  const SequenceNumber later{ledger_.count(writer) + static_cast<std::int64_t>(dice_.below(2000))};
  if (dice_.chance(500))
    return forged(writer.prefix, Heartbeat{.reader = kEntityIdUnknown,
                                           .writer = writer.entity,
                                           .first = later.next(),
                                           .last = later.next(),
                                           .count = static_cast<std::int32_t>(dice_.next()),
                                           .asserts_liveliness = dice_.chance(500)});
  return forged(writer.prefix, Gap{.reader = kEntityIdUnknown,
                                   .writer = writer.entity,
                                   .start = {1},
                                   .list = SequenceNumberSet(later.next())});
}

Bytes Forger::handshake() {
  auto message = read_generic_message(heard(kStatelessMessageWriter));
  if (!message || message->data.empty()) return {};
  auto& token = message->data.front();
  for (auto& property : token.binary_properties)
    if (dice_.chance(200) && !property.value.empty())
      property.value[dice_.below(property.value.size())] ^= dice_.octet();
  if (dice_.chance(100)) token.class_id = "DDS:Auth:PKI-DH:1.0+Req";
  auto from = message->identity.source.prefix;
  if (dice_.chance(300)) message->destination_participant.prefix = name();
  if (dice_.chance(300)) from = message->identity.source.prefix = name();
  return testing::stateless(from, *message);
}

Bytes Forger::question() {
  return testing::handshake_message(name(), name(),
                                    spi::Token{"DDS:Auth:PKI-DH:1.0+AuthReq", {}, {}},
                                    message_class::kAuthRequest);
}

Bytes Forger::handshake_fragment() {
  const auto octets = dice_.octets(dice_.chance(300) ? 60'000 : 600);
  const auto size = dice_.chance(500) ? 1u : octets.size();
  return forged(name(), DataFrag{.reader = kStatelessMessageReader,
                                 .writer = kStatelessMessageWriter,
                                 .sequence_number = {static_cast<std::int64_t>(dice_.below(5) + 1)},
                                 .first = {static_cast<std::uint32_t>(1 + dice_.below(100))},
                                 .count = static_cast<std::uint16_t>(octets.size() / size),
                                 .fragment_size = static_cast<std::uint16_t>(size),
                                 .sample_size = 200'000,
                                 .payload = octets});
}

Bytes Forger::keys() {
  GenericMessage message;
  message.identity = {{name(), kVolatileMessageWriter}, 1};
  message.destination_participant = {name(), kEntityIdParticipant};
  message.message_class = message_class::kParticipantTokens;
  message.data = {cryptography::testing::Insider(cryptography::kAes256Gcm).token()};
  const auto payload = write_generic_message(message);
  return forged(message.identity.source.prefix,
                Data{kVolatileMessageReader,
                     kVolatileMessageWriter,
                     {static_cast<std::int64_t>(1 + dice_.below(60))},
                     {},
                     PayloadKind::data,
                     payload});
}

Bytes Forger::liveliness() {
  const auto whose = name();
  Bytes payload = {0, 1, 0, 0};
  payload.insert(payload.end(), whose.octets.begin(), whose.octets.end());
  const Bytes rest = {0, 0, 0, static_cast<std::uint8_t>(1 + dice_.below(2)), 0, 0, 0, 0};
  payload.insert(payload.end(), rest.begin(), rest.end());
  const auto writer =
      dice_.chance(500) ? kParticipantMessageWriter : kParticipantMessageSecureWriter;
  const auto number = static_cast<std::int64_t>(1 + dice_.below(1000));
  return forged(whose, Data{kEntityIdUnknown, writer, {number}, {}, PayloadKind::data, payload});
}

Bytes Forger::behind(const std::function<void(SpanWriter&)>& what) {
  const auto& octets = dice_.of(recorded_).octets;
  if (octets.size() < kHeaderSize || octets.size() > 60'000) return {};
  Bytes buffer(octets.size() + 100);
  SpanWriter out(buffer);
  out.write_bytes(BytesView(octets).first(kHeaderSize));
  what(out);
  out.write_bytes(BytesView(octets).subspan(kHeaderSize));
  return to_bytes(out.view());
}

Bytes Forger::other_time() {
  return behind([&](SpanWriter& out) {
    write(out, InfoTimestamp{Time{{static_cast<std::int32_t>(dice_.below(0x7fffffff)), 0}}});
  });
}

Bytes Forger::other_destination() {
  return behind([&](SpanWriter& out) {
    InfoDestination to;
    to.prefix = dice_.chance(300) ? GuidPrefix{} : name();
    write(out, to);
    if (!dice_.chance(300)) return;
    InfoSource source;
    source.source.prefix = name();
    write(out, source);
  });
}

// Returns an announcement with addresses at which no other machine can be.
Bytes Forger::local_address() {
  return changed_announcement([&](ParticipantData& data) {
    const Locator here = Locator::udp_v4({127, 0, 0, dice_.octet()}, 7400);
    data.metatraffic_unicast.assign(1 + dice_.below(2), here);
    if (dice_.chance(500))
      data.metatraffic_unicast.push_back(Locator::udp_v4({192, 0, 2, 7}, 7400));
    if (dice_.chance(500)) data.default_unicast = {here};
  });
}

// Returns an announcement in which one parameter comes once more, with the value that it has in
// another announcement.
Bytes Forger::repeated_parameter() {
  const auto one = heard(kSpdpWriter), other = heard(kSpdpWriter);
  constexpr std::size_t kEncapsulation = 4;
  if (one.size() < kEncapsulation || other.size() < kEncapsulation) return {};
  const auto first = parameters_of(BytesView(one).subspan(kEncapsulation));
  const auto more = parameters_of(BytesView(other).subspan(kEncapsulation));
  if (first.empty() || more.empty()) return {};
  const auto place = dice_.below(first.size());
  Bytes payload(one.begin(), one.begin() + kEncapsulation);
  const auto add = [&](BytesView octets) {
    payload.insert(payload.end(), octets.begin(), octets.end());
  };
  for (std::size_t i = 0; i < first.size(); ++i) {
    if (i == place) add(dice_.of(more));
    add(first[i]);
  }
  add(Bytes{1, 0, 0, 0});
  return forged(name(), Data{kSpdpReader, kSpdpWriter, {1}, {}, PayloadKind::data, payload});
}

Bytes Forger::garbage() {
  auto out = dice_.octets(dice_.below(3000));
  const auto& octets = dice_.of(recorded_).octets;
  std::copy_n(octets.begin(), std::min({octets.size(), out.size(), kHeaderSize}), out.begin());
  return out;
}

}  // namespace ddssec::rtps::sim
