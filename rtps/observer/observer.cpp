#include "rtps/observer/observer.hpp"

#include "rtps/discovery/endpoint_data.hpp"
#include "rtps/security/generic_message.hpp"
#include "rtps/transport/ports.hpp"
#include "wire/data_frag.hpp"
#include "wire/entity_ids.hpp"
#include "wire/info_destination.hpp"
#include "wire/info_source.hpp"

namespace ddssec::rtps {
namespace {

DomainId domain_of(const ParticipantData& data, std::uint16_t port) {
  if (data.domain_id) return static_cast<DomainId>(*data.domain_id);
  return ports::domain_of(port);
}

std::optional<HandshakeStep> step_of(const GenericMessage& message) {
  if (message.message_class == message_class::kAuthRequest) return HandshakeStep::auth_request;
  if (message.message_class != message_class::kAuthentication || message.data.empty())
    return std::nullopt;
  const std::string_view token = message.data.front().class_id;
  if (token.ends_with("+Req")) return HandshakeStep::request;
  if (token.ends_with("+Reply")) return HandshakeStep::reply;
  if (token.ends_with("+Final")) return HandshakeStep::final;
  return std::nullopt;
}

// Returns the kind at the beginning of a CryptoHeader (DDS-Security 1.2, clause 10.5.2.3).
std::optional<TransformKind> kind_in(BytesView octets) {
  if (octets.size() < 20) return std::nullopt;
  return TransformKind::from(octets.first(TransformKind::size));
}

// True if the payload begins with the kind of a CryptoHeader. A CDR encapsulation begins with its
// representation id and two octets of options, and none of these has the value of a kind.
bool is_encrypted(BytesView payload) {
  const auto kind = kind_in(payload);
  return kind && kind->octets[0] == 0 && kind->octets[1] == 0 && kind->octets[3] != 0;
}

bool is_user_writer(const EntityId& id) { return is_user_defined(id) && is_writer(id); }

}  // namespace

std::string_view to_string(HandshakeStep step) {
  constexpr std::array<std::string_view, 5> kNames = {"auth_request", "request", "reply", "final",
                                                      "keys"};
  return kNames.at(static_cast<std::size_t>(step));
}

void Sightings::note(MonotonicTime at) {
  if (count++ == 0) first = at;
  last = at;
}

const HandshakeFlow& Observer::flow(const GuidPrefix& from, const GuidPrefix& to) const {
  static const HandshakeFlow nothing;
  const auto at = flows_.find({from, to});
  return at == flows_.end() ? nothing : at->second;
}

ObservedParticipant* Observer::find(const GuidPrefix& prefix) {
  const auto at = participants_.find(prefix);
  if (at != participants_.end()) return &at->second;
  if (participants_.size() >= kMaxParticipants) {
    ++left_out_;
    return nullptr;
  }
  return &participants_[prefix];
}

HandshakeFlow* Observer::flow_to(const Message& message, const GuidPrefix& to) {
  const std::pair key{message.source, to};
  if (flows_.size() >= kMaxFlows && !flows_.contains(key)) return nullptr;
  return &flows_[key];
}

void Observer::on_datagram(BytesView datagram, const Arrival& arrival) {
  datagrams_.note(arrival.at);
  auto reader = MessageReader::open(datagram);
  if (!reader) return;
  ++rtps_messages_;
  const auto& header = reader->header();
  Message message{header.prefix, {}, find(header.prefix), arrival};
  if (message.sender == nullptr) return;
  message.sender->vendor = header.vendor;
  message.sender->messages.note(arrival.at);
  if (message.sender->addresses.size() < kMaxAddressesEach)
    message.sender->addresses.emplace(arrival.from);
  walk(*reader, message);
}

void Observer::walk(MessageReader reader, Message& message) {
  for (;;) {
    const auto view = reader.next();
    if (!view || !*view) return;
    on_submessage(**view, message);
  }
}

// A submessage that cannot be read is ignored.
void Observer::on_submessage(const SubmessageView& view, Message& message) {
  switch (view.id) {
    case SubmessageId::info_destination:
      if (const auto info = read_info_destination(view)) message.destination = info->prefix;
      return;
    case SubmessageId::info_source:
      return on_source(view, message);
    case SubmessageId::secure_prefix:
    case SubmessageId::secure_rtps_prefix:
      return on_protected(view, message);
    case SubmessageId::data:
      if (const auto data = read_data(view)) on_data(*data, message);
      return;
    case SubmessageId::data_frag: {
      const auto frag = read_data_frag(view);
      if (!frag) return;
      if (is_user_writer(frag->writer) && frag->first.value == 1)
        ++(is_encrypted(frag->encoded) ? message.sender->encrypted_payloads
                                       : message.sender->clear_samples);
      if (frag->writer != kStatelessMessageWriter) return;
      const auto whole = fragments_.add(message.source, *frag, message.arrival.at);
      if (!whole.empty()) on_stateless(whole.front(), message);
      return;
    }
    default:
      return;
  }
}

void Observer::on_source(const SubmessageView& view, Message& message) {
  const auto info = read_info_source(view);
  auto* sender = info ? find(info->source.prefix) : nullptr;
  if (sender == nullptr) return;
  message.source = info->source.prefix;
  message.sender = sender;
}

void Observer::on_protected(const SubmessageView& prefix, const Message& message) {
  auto& sender = *message.sender;
  const bool whole = prefix.id == SubmessageId::secure_rtps_prefix;
  ++(whole ? sender.protected_messages : sender.protected_submessages);
  const auto kind = kind_in(prefix.body);
  if (kind && sender.kinds.size() < kMaxKindsEach) sender.kinds.insert(*kind);
  if (whole || message.destination.is_zero()) return;
  if (auto* flow = flow_to(message, message.destination))
    flow->at(HandshakeStep::keys).note(message.arrival.at);
}

void Observer::on_data(const Data& data, const Message& message) {
  if (data.writer == kSpdpWriter) return on_announcement(data, message);
  if (data.writer == kStatelessMessageWriter) return on_stateless(data.payload, message);
  if (data.writer == kPublicationsWriter || data.writer == kSubscriptionsWriter)
    return on_topic(data, message);
  if (is_user_writer(data.writer) && data.kind != PayloadKind::none)
    ++(is_encrypted(data.payload) ? message.sender->encrypted_payloads
                                  : message.sender->clear_samples);
}

void Observer::on_announcement(const Data& data, const Message& message) {
  auto& sender = *message.sender;
  if (data.kind == PayloadKind::key || data.inline_qos.status.disposed) {
    sender.has_left = true;
    return;
  }
  auto announced = read_participant_data(data.payload);
  if (!announced || announced->guid.prefix != message.source) return;
  sender.domain = domain_of(*announced, message.arrival.port);
  sender.has_left = false;
  sender.data = *std::move(announced);
}

void Observer::on_topic(const Data& data, const Message& message) {
  if (data.kind != PayloadKind::data) return;
  const bool is_written = data.writer == kPublicationsWriter;
  const auto endpoint =
      is_written ? read_publication_data(data.payload) : read_subscription_data(data.payload);
  if (!endpoint) return;
  auto* const topic = topic_of(*message.sender, *endpoint);
  if (topic == nullptr) {
    ++left_out_;
    return;
  }
  (is_written ? topic->is_written : topic->is_read) = true;
}

ObservedTopic* Observer::topic_of(ObservedParticipant& sender, const EndpointData& endpoint) {
  auto& topics = sender.clear_topics;
  const auto known = topics.find(endpoint.topic_name);
  const auto before = known == topics.end() ? 0 : known->second.octets;
  const auto octets = kPricePerTopic + endpoint.topic_name.size() + endpoint.type_name.size();
  const auto of_sender = sender.topic_octets - before + octets;
  const auto of_all = topic_octets_ - before + octets;
  if (known == topics.end() && topics.size() >= kMaxTopicsEach) return nullptr;
  if (of_sender > kTopicOctetsOfEach && of_all > kMaxTopicOctets) return nullptr;
  sender.topic_octets = of_sender;
  topic_octets_ = of_all;
  auto& topic = topics[endpoint.topic_name];
  topic.type = endpoint.type_name;
  topic.octets = octets;
  return &topic;
}

void Observer::on_stateless(BytesView payload, const Message& message) {
  const auto said = read_generic_message(payload);
  const auto step = said ? step_of(*said) : std::nullopt;
  if (!step || said->identity.source.prefix != message.source) return;
  if (auto* flow = flow_to(message, said->destination_participant.prefix))
    flow->at(*step).note(message.arrival.at);
  if (!read_certificate_ || message.sender->certificate || said->data.empty()) return;
  if (const auto* pem = spi::find_binary_property(said->data.front(), "c.id"))
    message.sender->certificate = read_certificate_(*pem);
}

}  // namespace ddssec::rtps
