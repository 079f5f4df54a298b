// Participant, the part that security drives (DDS-Security 7.4, 8.8).
#include <algorithm>

#include "rtps/participant/participant.hpp"

namespace ddssec::rtps {
namespace {

/// c.pdata; the plugin refuses more.
constexpr std::size_t kMostOwnData = 16384;

}  // namespace

Status Participant::secure(std::unique_ptr<OwnSecurity> own) {
  SecurityHost& host = *this;
  security_ = std::make_unique<Security>(std::move(own), sender_, timers_, host, events_);
  builtin_.secure();
  receiver_.open_with(security_->keyring());
  Bytes octets(kMostOwnData);
  SpanWriter out(octets, Endian::big);
  write_parameter_list(out, own_data());
  if (out.overflowed()) return fail(Code::length_out_of_range, {.document = "participant data"});
  octets.resize(out.size());
  DDSSEC_TRY(security_->start(std::move(octets)));
  announce_securely(false);
  return {};
}

Status Participant::revise_keys() {
  return security_ ? security_->revise_keys() : fail(Code::rtps_key_revision_disabled);
}

void Participant::announce_securely(bool leaving) {
  if (!security_) return;
  std::array<std::uint8_t, MessageSender::kLargestMessage> buffer;
  SpanWriter payload(buffer);
  const Guid guid{config_.prefix, kEntityIdParticipant};
  Change change;
  change.key_hash = guid.octets();
  change.key_only = leaving;
  if (leaving) {
    change.status = {true, true};
    write_participant_key(payload, guid);
  } else {
    auto own = own_data();
    own.entity_name = config_.entity_name;
    own.user_data = config_.user_data;
    write_payload(payload, own);
  }
  change.payload = Payload::copy_of(payload.view());
  builtin_.writer(BuiltinTopic::participants_secure).write(std::move(change), now_);
}

// Only a participant itself, and by its own keys, says what it is and that it leaves.
void Participant::on_secure_participant(const Change& change) {
  const auto& prefix = change.writer.prefix;
  const auto remote = remotes_.find(prefix);
  if (remote == remotes_.end()) return;
  if (!change.is_alive()) return gone_.push_back(prefix);
  auto data = read_participant_data(change.payload.view());
  if (!data || data->guid.prefix != prefix) {
    ++counters_.refused_discovery;
    return;
  }
  remote->second.data.user_data = std::move(data->user_data);
  remote->second.data.entity_name = std::move(data->entity_name);
  remote->second.data.lease_duration = data->lease_duration;
  tell_of(remote->second);
}

void Participant::on_authenticated(const GuidPrefix& peer) {
  if (const auto at = remotes_.find(peer); at != remotes_.end()) match_builtin(at->second);
}

// DDS-Security 8.8.2.1: then it may be one of those that need not authenticate.
void Participant::on_refused(const GuidPrefix& peer) {
  const auto at = remotes_.find(peer);
  if (at != remotes_.end() && security_->admits_unauthenticated()) match_builtin(at->second);
}

LocatorList Participant::on_proven(const GuidPrefix& peer, const ParticipantData& proven) {
  const auto at = remotes_.find(peer);
  auto metatraffic = usable_locators(proven.metatraffic_unicast, {}, config_.interfaces);
  if (at == remotes_.end()) return metatraffic;
  auto& remote = at->second;
  remote.data.vendor = proven.vendor;
  remote.data.builtin_endpoints = proven.builtin_endpoints;
  remote.user = usable_locators(proven.default_unicast, remote.user, config_.interfaces);
  // Cyclone DDS leaves it to DCPSParticipantsSecure.
  if (proven.vendor != kVendorCyclone) remote.data.lease_duration = proven.lease_duration;
  if (!metatraffic.empty()) remote.metatraffic = metatraffic;
  return metatraffic;
}

void Participant::on_replaced(const GuidPrefix& peer) {
  if (const auto at = remotes_.find(peer); at != remotes_.end()) unmatch(at->second);
}

void Participant::on_ended(const GuidPrefix& peer) { gone_.push_back(peer); }

void Participant::on_keys(const EntityId& local, const Guid& remote) {
  const auto at = remotes_.find(remote.prefix);
  if (at == remotes_.end()) return;
  if (is_builtin(local)) {
    for (const auto& info : kBuiltinTopics)
      if (info.writer == local || info.reader == local)
        match_builtin(info, at->second, info.writer == local);
    return;
  }
  const auto endpoint = at->second.endpoints.find(remote.entity);
  if (endpoint == at->second.endpoints.end()) return;
  if (const auto writer = writers_.find(local); writer != writers_.end())
    match(writer->second, at->second, endpoint->second.data);
  if (const auto reader = readers_.find(local); reader != readers_.end())
    match(reader->second, at->second, endpoint->second.data);
}

void Participant::on_early_keys(const Guid& remote) {
  if (remote.entity == kParticipantsSecureWriter || remote.entity == kParticipantsSecureReader)
    note_participants_secure(remote.prefix);
}

bool Participant::introduce(const EntityId& local, const EndpointData& remote, bool& keep) {
  if (!security_ || remote.guid.prefix == config_.prefix) return true;
  const auto admission = security_->admit(
      local, {remote.guid, remote.topic_name, remote.qos.partition, remote.qos.data_tags,
              remote.security_info.value_or(spi::SecurityInfo{}), remote.by_secure_discovery,
              remote.required_ciphers});
  keep = admission.has_value();
  return keep && security_->introduce(local, remote.guid, admission->relay_only);
}

}  // namespace ddssec::rtps
