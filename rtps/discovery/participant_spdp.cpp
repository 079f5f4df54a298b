// Participant, the half that finds other participants (RTPS 8.5.3).
#include <algorithm>

#include "rtps/discovery/participant.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::uint32_t kOurEndpoints = builtin_endpoints::kParticipant |
                                        builtin_endpoints::kPublications |
                                        builtin_endpoints::kSubscriptions;

KeyHash key_of(const Guid& guid) { return guid.octets(); }

}  // namespace

// An announcement may name any address; only what one can send to, and little of it, is used.
LocatorList usable_locators(const LocatorList& announced, const LocatorList& fallback) {
  constexpr std::size_t kMostUsed = 4;
  LocatorList out;
  for (const auto& locator : announced)
    if (locator.is_usable() && !locator.is_multicast() && out.size() < kMostUsed)
      out.push_back(locator);
  return out.empty() ? fallback : out;
}

MonotonicTime lease_end(const ParticipantData& data, MonotonicTime now) {
  const auto lease = data.lease_duration.to_nanoseconds();
  return data.lease_duration.is_infinite() ? kNever : now + lease;
}

void Participant::announce(std::span<const Locator> to) {
  ParticipantData own;
  own.guid = {config_.prefix, kEntityIdParticipant};
  own.vendor = kVendorDdssec;
  own.domain_id = static_cast<std::uint32_t>(config_.domain_id);
  own.domain_tag = config_.domain_tag;
  own.builtin_endpoints = kOurEndpoints;
  own.lease_duration = config_.lease_duration;
  own.metatraffic_unicast = config_.metatraffic_unicast;
  own.metatraffic_multicast = config_.metatraffic_multicast;
  own.default_unicast = config_.default_unicast;
  own.entity_name = config_.entity_name;
  own.user_data = config_.user_data;
  std::array<std::uint8_t, MessageSender::kLargestMessage> buffer;
  SpanWriter payload(buffer);
  write_payload(payload, own);
  const Data data{kSpdpReader, kSpdpWriter, {1}, {}, PayloadKind::data, payload.view()};
  sender_.add({{}, to}, data);
  sender_.flush();
}

void Participant::leave() {
  std::array<std::uint8_t, 64> buffer;
  SpanWriter payload(buffer);
  const Guid guid{config_.prefix, kEntityIdParticipant};
  write_participant_key(payload, guid);
  // Fast DDS takes the instance from the key hash alone.
  const Data data{kSpdpReader,      kSpdpWriter,   {2}, {key_of(guid), {true, true}},
                  PayloadKind::key, payload.view()};
  sender_.add({{}, config_.announce_to}, data);
  sender_.flush();
  for (const auto& [prefix, remote] : remotes_) {
    sender_.add({{}, remote.metatraffic}, data);
    sender_.flush();
  }
}

Status Participant::on_spdp(const Data& data, const Context& context) {
  if (data.inline_qos.status != StatusInfo{} || data.kind == PayloadKind::key) {
    const auto guid = data.inline_qos.key_hash
                          ? GuidPrefix::from(BytesView(*data.inline_qos.key_hash).first(12))
                          : DDSSEC_TRY(read_participant_key(data.payload)).prefix;
    // Only itself can say that a participant is gone.
    if (guid == context.source) remove_remote(guid);
    return {};
  }
  if (data.kind != PayloadKind::data) return {};
  auto announced = DDSSEC_TRY(read_participant_data(data.payload));
  const auto domain = static_cast<std::uint32_t>(config_.domain_id);
  const bool ours =
      announced.domain_id.value_or(domain) == domain && announced.domain_tag == config_.domain_tag;
  if (!ours || announced.guid.prefix == config_.prefix) return {};
  if (announced.guid.prefix != context.source) {
    ++counters_.refused_discovery;
    return {};
  }
  add_remote(std::move(announced), context.now);
  return {};
}

void Participant::add_remote(ParticipantData data, MonotonicTime now) {
  const auto prefix = data.guid.prefix;
  if (const auto known = remotes_.find(prefix); known != remotes_.end()) {
    known->second.lease_end = lease_end(data, now);
    return;
  }
  auto metatraffic = usable_locators(data.metatraffic_unicast, {});
  if (remotes_.size() >= kMostParticipants || metatraffic.empty()) {
    ++counters_.refused_discovery;
    return;
  }
  auto user = usable_locators(data.default_unicast, metatraffic);
  const auto end = lease_end(data, now);
  auto& remote =
      remotes_[prefix] = {std::move(data), std::move(metatraffic), std::move(user), end, {}, {}};
  announce(remote.metatraffic);
  match_builtin(remote, now);
}

void Participant::match_builtin(Remote& remote, MonotonicTime now) {
  const auto set = remote.data.builtin_endpoints;
  const auto& prefix = remote.data.guid.prefix;
  const auto has = [&](std::uint32_t pair, bool reader) {
    return (set & pair & (reader ? 0xaaaaaaaau : 0x55555555u)) != 0;
  };
  const auto writer_of = [&](const EntityId& id) {
    return MatchedWriter{{prefix, id}, true, remote.metatraffic};
  };
  const auto reader_of = [&](const EntityId& id) {
    return MatchedReader{{prefix, id}, true, true, remote.metatraffic};
  };
  if (has(builtin_endpoints::kPublications, false))
    publications_reader_.match(writer_of(kPublicationsWriter), now);
  if (has(builtin_endpoints::kSubscriptions, false))
    subscriptions_reader_.match(writer_of(kSubscriptionsWriter), now);
  if (has(builtin_endpoints::kPublications, true))
    publications_writer_.match(reader_of(kPublicationsReader), now);
  if (has(builtin_endpoints::kSubscriptions, true))
    subscriptions_writer_.match(reader_of(kSubscriptionsReader), now);
}

void Participant::remove_remote(const GuidPrefix& prefix) {
  const auto at = remotes_.find(prefix);
  if (at == remotes_.end()) return;
  while (!at->second.endpoints.empty())
    remove_endpoint(at->second, at->second.endpoints.begin()->first);
  publications_reader_.unmatch({prefix, kPublicationsWriter});
  subscriptions_reader_.unmatch({prefix, kSubscriptionsWriter});
  publications_writer_.unmatch({prefix, kPublicationsReader});
  subscriptions_writer_.unmatch({prefix, kSubscriptionsReader});
  remotes_.erase(at);
}

}  // namespace ddssec::rtps
