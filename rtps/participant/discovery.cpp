#include "rtps/participant/discovery.hpp"

#include <algorithm>

#include "rtps/participant/proven_data.hpp"
#include "rtps/participant/remote_addresses.hpp"

namespace ddssec::rtps {
namespace {

// Leaves out loopback addresses that another machine announced. Otherwise it could make this
// participant send to services on the local machine.
void leave_out_loopback(const ParticipantCore& core, LocatorList& announced) {
  if (core.is_from_elsewhere)
    std::erase_if(announced, [](const Locator& locator) { return locator.is_loopback(); });
}

// Returns the addresses that this participant can use, or `fallback` if none was announced.
LocatorList usable(const ParticipantCore& core, LocatorList announced,
                   const LocatorList& fallback = {}) {
  leave_out_loopback(core, announced);
  return usable_locators(announced, fallback, core.config.interfaces);
}

// A peer that has not proven its identity may announce addresses of other hosts. So the answer
// goes to the address that it announced itself from, or to one address.
LocatorList where_to_answer(const LocatorList& metatraffic, const SourceAddress& source) {
  LocatorList out;
  for (const auto& locator : metatraffic)
    if (SourceAddress(locator) == source) out.push_back(locator);
  if (out.empty()) out.push_back(metatraffic.front());
  return out;
}

// Reports an endpoint announcement that cannot be read. The topic still shows whether it is a
// writer or a reader.
void raise_unreadable(ParticipantCore& core, const Error& error, const GuidPrefix& source,
                      BuiltinTopic topic) {
  const Guid some{source, is_of_writers(topic) ? kPublicationsWriter : kPublicationsReader};
  core.raise(error.with_default_document("SEDP"), source, source.to_string(),
             core.origin_of_announcement(some, is_secure(topic)));
}

void note_unproven_ends(EndpointMatcher& matcher, RemoteParticipant& remote) {
  for (const auto& [id, endpoint] : remote.endpoints) matcher.note_unproven_end(remote, id);
}

void note_heard(RemoteParticipants& remotes, BuiltinMatcher& builtin, const Guid& of) {
  if (of.entity != kParticipantsSecureWriter && of.entity != kParticipantsSecureReader) return;
  if (auto* known = remotes.find(of.prefix)) builtin.note_participants_secure(*known);
}

// A datagram arrived in this participant's name. If sending to it is limited, more may now be
// sent.
void note_credit(ParticipantCore& core, const GuidPrefix& source) {
  const auto octets = core.sender.amplification_limit().add_credit(source);
  if (octets > 0 && core.security) core.security->note_credit(source, octets);
}

}  // namespace

Discovery::Discovery(ParticipantCore& core, const Parts& parts)
    : core_(core),
      parts_(parts),
      builtin_(core, parts.local.builtin()),
      links_(core, parts.remotes, parts.matcher, builtin_),
      clear_(core, parts.local, parts.remotes, parts.matcher, builtin_),
      proven_(core, parts.remotes, parts.matcher, builtin_),
      resting_(core, parts.remotes, parts.matcher, builtin_) {}

// ---- participants that are found

Status Discovery::on_announcement(const GuidPrefix& source, const Data& data) {
  if (data.inline_qos.status != StatusInfo{} || data.kind == PayloadKind::key) {
    GuidPrefix guid;
    if (data.inline_qos.key_hash) {
      guid = GuidPrefix::from(BytesView(*data.inline_qos.key_hash).first(12));
    } else {
      DDSSEC_ASSIGN_OR_RETURN(const auto key, read_participant_key(data.payload));
      guid = key.prefix;
    }
    if (guid == source) on_dispose(guid);
    return {};
  }
  if (data.kind != PayloadKind::data) return {};
  DDSSEC_ASSIGN_OR_RETURN(auto announced, read_participant_data(data.payload));
  const auto& config = core_.config;
  const bool is_of_our_domain = is_of_domain(announced, config.domain_id, config.domain_tag);
  if (!is_of_our_domain || announced.guid.prefix == config.prefix) return {};
  if (announced.guid.prefix != source || source == GuidPrefix{}) {  // GUIDPREFIX_UNKNOWN
    ++core_.counters.refused_discovery;
    return {};
  }
  if (core_.ignored.contains(source)) return {};
  if (auto* known = parts_.remotes.find(source))
    on_announced_again(*known, std::move(announced), data.payload.size());
  else
    add(std::move(announced), data.payload.size());
  return {};
}

void Discovery::add(ParticipantData data, std::size_t octets) {
  auto& remotes = parts_.remotes;
  auto metatraffic = usable(core_, data.metatraffic_unicast);
  auto* security = core_.security.get();
  // A stranger with the GUID of a dormant peer must not end the keys of the peer's endpoints.
  const bool is_stranger = security != nullptr && security->dormant().contains(data.guid.prefix) &&
                           !security->may_authenticate(data);
  if (metatraffic.empty() || is_stranger || !links_.make_room(octets)) {
    ++core_.counters.refused_discovery;
    return;
  }
  auto user = usable(core_, data.default_unicast, metatraffic);
  const auto decision = security != nullptr ? security->judge(data)
                                            : Security::AdmissionDecision::admit_unauthenticated;
  auto& remote = remotes.add(std::move(data), std::move(metatraffic), std::move(user), octets);
  core_.sender.amplification_limit().begin(remote.prefix(), remote.metatraffic,
                                           remote.metatraffic_sources);
  core_.sender.amplification_limit().add_credit(remote.prefix());
  parts_.announcer.answer(remote.prefix(), where_to_answer(remote.metatraffic, core_.source));
  if (decision == Security::AdmissionDecision::authenticate)
    security->discovered(remote.data,
                         {remote.metatraffic, remote.metatraffic_sources, core_.source}, core_.now);
  remotes.renew_lease(remote, remote.data);
  if (decision == Security::AdmissionDecision::admit_unauthenticated) links_.accept(remote);
}

// An attacker can send announcements in a participant's name, and may have sent the first one.
void Discovery::on_announced_again(RemoteParticipant& remote, ParticipantData data,
                                   std::size_t octets) {
  const auto prefix = data.guid.prefix;
  // An announcement changes nothing of an authenticated participant and does not renew its lease.
  // As long as nothing is proven, every announcement counts, and no lease becomes shorter.
  const bool is_fixed = core_.is_authenticated(prefix);
  if (!is_fixed) parts_.remotes.renew_lease(remote, data);
  if (!is_fixed && remote.accepted && remote.data.user_data != data.user_data) {
    remote.data.user_data = data.user_data;
    parts_.remotes.on_changed(remote);
  }
  auto* security = core_.security.get();
  if (security != nullptr) security->note_announced(prefix, core_.now);
  if (is_fixed || security == nullptr || !security->may_authenticate(data)) return;
  const bool has_changed = data != remote.data;
  if (!security->knows(prefix)) {
    if (!has_changed) return;
    remove(prefix);
    return add(std::move(data), octets);
  }
  // Addresses that the handshake has signed stay, even while keys are still being exchanged.
  if (remote.has_signed_addresses && security->has_proven_identity(prefix)) return;
  if (!parts_.remotes.grow(remote, octets)) {
    ++core_.counters.refused_discovery;
    return;
  }
  const auto added = add_locators(remote.metatraffic, remote.metatraffic_sources,
                                  usable(core_, data.metatraffic_unicast), core_.source);
  if (added.has_displaced) remote.has_displaced_addresses = true;
  add_locators(remote.user, remote.user_sources, usable(core_, data.default_unicast), core_.source);
  core_.sender.amplification_limit().set_addresses(prefix, remote.metatraffic,
                                                   remote.metatraffic_sources);
  // A repetition of the first announcement counts again, because forged ones may have replaced its
  // addresses.
  if (!has_changed && !added.has_new) return;
  security->announced_again(data, {remote.metatraffic, remote.metatraffic_sources, core_.source},
                            core_.now);
}

// Any message shows that a participant is alive, as long as it is not authenticated. In the name of
// an authenticated participant, an attacker can repeat old messages and invent new ones. So only a
// message that is new and protected by the participant's own keys counts. For its writers, less is
// sufficient if the governance protects neither messages nor liveliness. Whatever the governance
// leaves unprotected, the participant answers when it is queried on the volatile secure channel
// (tick). If it was dormant, only such an answer counts.
void Discovery::on_message(const GuidPrefix& source, const SignsOfLife& signs) {
  if (core_.security && core_.security->dormant().contains(source))
    core_.security->dormant().note_heard(source, core_.now);
  auto* remote = parts_.remotes.find(source);
  if (remote == nullptr) return;
  note_credit(core_, source);
  const bool is_proof = remote->has_returned ? signs.is_lasting_proof : signs.is_proof;
  if (is_proof && prove_host(core_, *remote, core_.source_host)) links_.readdress(*remote);
  if (signs.is_directed && remote->accepted && has_proven_address(core_, *remote))
    core_.sender.amplification_limit().end(source);
  const bool anything_counts = !core_.is_authenticated(source);
  const auto& attributes = core_.attributes();
  const bool may_be_clear =
      !attributes.is_rtps_protected() && !attributes.is_liveliness_protected();
  if (anything_counts || is_proof) parts_.remotes.renew_lease(*remote, remote->data);
  if (anything_counts || signs.is_proof || (signs.is_news && may_be_clear))
    parts_.liveliness.note_alive(*remote, LivelinessKind::automatic);
}

// ---- participants that leave

// Only a participant itself can report that it leaves; once authenticated, only by the secure
// topic. Fast DDS and Cyclone DDS do not report it there, and a peer that is only out of reach
// keeps its session. We therefore query each of its readers, and remove the participant when its
// lease ends.
void Discovery::on_dispose(const GuidPrefix& prefix) {
  auto* remote = parts_.remotes.find(prefix);
  if (remote == nullptr) return;
  const bool is_authenticated = core_.is_authenticated(prefix);
  const auto& vendor = remote->data.vendor;
  if (is_authenticated && (vendor == kVendorFastDds || vendor == kVendorCyclone))
    note_unproven_ends(parts_.matcher, *remote);
  else if (is_authenticated || (core_.security && core_.security->is_authenticating(prefix)))
    ++core_.counters.refused_discovery;
  else
    gone_.push_back(prefix);
}

void Discovery::tick() {
  proven_.tick();
  const auto due = parts_.remotes.take_due();
  for (const auto& prefix : due.queries) core_.security->ask_for_sign_of_life(prefix);
  remove_gone();
  for (const auto& prefix : due.ended_leases) {
    auto* const remote = parts_.remotes.find(prefix);
    if (remote == nullptr) continue;
    if (resting_.can_keep(*remote))
      resting_.rest(*remote);
    else
      remove(prefix);
  }
}

void Discovery::remove_gone() {
  for (const auto& prefix : std::exchange(gone_, {})) remove(prefix);
  if (!core_.security) return;
  auto& dormant = core_.security->dormant();
  for (const auto& prefix : dormant.take_answered()) {
    if (!dormant.contains(prefix)) continue;
    remove(prefix);  // what was announced in its name meanwhile proves nothing
    auto* remote = links_.make_room(0) ? resting_.wake(prefix) : nullptr;
    if (remote != nullptr && core_.is_authenticated(prefix)) join(*remote, true);
  }
}

// ---- changes for builtin readers

void Discovery::on_builtin(BuiltinTopic topic, const Change& change) {
  switch (topic) {
    case BuiltinTopic::publications:
    case BuiltinTopic::publications_secure:
    case BuiltinTopic::subscriptions:
    case BuiltinTopic::subscriptions_secure:
      return on_endpoint(topic, change);
    case BuiltinTopic::participant_message:
    case BuiltinTopic::participant_message_secure:
      return parts_.liveliness.on_participant_message(change, is_secure(topic));
    case BuiltinTopic::participants_secure:
      return on_secure_participant(change);
  }
}

// A participant may announce only its own endpoints. An unprotected message cannot change what was
// announced securely, but makes our writers query a reader that it reports as ended. A secure
// announcement replaces what an attacker may have announced before.
void Discovery::on_endpoint(BuiltinTopic topic, const Change& change) {
  const bool is_by_secure_topic = is_secure(topic);
  auto* remote = parts_.remotes.find(change.writer.prefix);
  if (remote == nullptr) return;
  const auto may_change = [&](const EntityId& id) {
    const auto known = remote->endpoints.find(id);
    return is_by_secure_topic || known == remote->endpoints.end() ||
           !known->second.data.by_secure_discovery;
  };
  if (!change.is_alive()) {
    const auto key = change.key_hash ? Guid::from(*change.key_hash)
                                     : read_endpoint_key(change.payload.view()).value_or(Guid{});
    if (key.prefix != remote->prefix()) return;
    if (may_change(key.entity)) {
      clear_.remove(*remote, key.entity, is_by_secure_topic);
      return;
    }
    ++core_.counters.refused_discovery;
    return parts_.matcher.note_unproven_end(*remote, key.entity);
  }
  auto data = is_of_writers(topic) ? read_publication_data(change.payload.view())
                                   : read_subscription_data(change.payload.view());
  if (!data || data->guid.prefix != remote->prefix()) {
    ++core_.counters.refused_discovery;
    if (!data) raise_unreadable(core_, data.error(), remote->prefix(), topic);
    return;
  }
  data->by_secure_discovery = is_by_secure_topic;
  leave_out_loopback(core_, data->unicast);
  if (!may_change(data->guid.entity)) {
    ++core_.counters.refused_discovery;
    return;
  }
  proven_.note_announced(*remote, *data);
  if (is_by_secure_topic) clear_.give_way_to(*remote, *data);
  if (!clear_.note_announced(*remote, *data)) return;
  parts_.matcher.add(*remote, std::move(*data));
}

// Only the participant itself, using its own keys, can announce its data or report that it leaves.
// Where nothing protects this topic, a report that it leaves is treated like one by SPDP, and the
// lease stays the one that it signed. Cyclone DDS signs none.
void Discovery::on_secure_participant(const Change& change) {
  auto* remote = parts_.remotes.find(change.writer.prefix);
  if (remote == nullptr) return;
  const bool is_proven = core_.is_participant_data_proven(remote->prefix());
  if (!change.is_alive())
    return is_proven ? gone_.push_back(remote->prefix())
                     : note_unproven_ends(parts_.matcher, *remote);
  auto data = read_participant_data(change.payload.view());
  if (!data || data->guid.prefix != remote->prefix()) {
    ++core_.counters.refused_discovery;
    return;
  }
  remote->data.user_data = std::move(data->user_data);
  remote->data.entity_name = std::move(data->entity_name);
  if (is_proven || remote->data.vendor == kVendorCyclone)
    remote->data.lease_duration = lease_that_counts(data->lease_duration, is_proven);
  parts_.remotes.on_changed(*remote);
  if (remote->data.vendor != kVendorDdssec) return;
  auto &metatraffic = data->metatraffic_unicast, &user = data->default_unicast;
  leave_out_loopback(core_, metatraffic);
  leave_out_loopback(core_, user);
  links_.follow(*remote, std::move(metatraffic), std::move(user));
}

void Discovery::on_addresses_changed(ChangedAddresses changed) {
  if (changed == ChangedAddresses::all)
    while (!parts_.remotes.all().empty()) remove(GuidPrefix(parts_.remotes.all().begin()->first));
  for (const auto& [prefix, known] : parts_.remotes.all())
    if (auto& remote = *parts_.remotes.find(prefix); choose_addresses_of(core_, remote))
      links_.readdress(remote);
}

void Discovery::on_acknack(const GuidPrefix& source, const AckNack& acknack, bool is_protected) {
  if (acknack.writer == kVolatileMessageWriter && core_.security)
    return core_.security->note_keys_acknowledged(source);
  auto* local = parts_.local.find_writer(acknack.writer);
  if (local == nullptr) return;
  parts_.matcher.presence().note_heard(*local, source, acknack, is_protected);
  local->listener->on_acknowledged();
}

// ---- security

void Discovery::on_stateless(const GuidPrefix& source, BytesView payload) {
  note_credit(core_, source);
  if (core_.security) core_.security->on_stateless(source, payload, core_.now);
}

void Discovery::on_stateless_frag(const GuidPrefix& source, const DataFrag& frag) {
  note_credit(core_, source);
  if (core_.security) core_.security->on_stateless_frag(source, frag, core_.source, core_.now);
}

void Discovery::on_key_exchange(const GuidPrefix& source) {
  if (core_.security) core_.security->note_key_exchange(source);
}

void Discovery::on_builtin_heartbeat(const Guid& writer) {
  if (core_.security) note_heard(parts_.remotes, builtin_, writer);
}

// The pair may have been unregistered because too many pairs waited for keys.
void Discovery::on_early_keys(const EntityId& local, const Guid& remote) {
  note_heard(parts_.remotes, builtin_, remote);
  if (!is_builtin(local) && core_.security->keyring().keys_for(local, remote).may_be_dropped)
    parts_.matcher.match(local, remote);
}

void Discovery::on_authenticated(const GuidPrefix& peer) {
  if (auto* remote = parts_.remotes.find(peer)) join(*remote, false);
}

void Discovery::join(RemoteParticipant& remote, bool returns) {
  if (remote.signed_metatraffic.empty()) adopt_signed_addresses(core_, remote, {}, {});
  links_.limit_until_proven(remote);
  links_.accept(remote, returns);
  if (returns) resting_.match_again(remote);
  clear_.begin(remote);
}

// DDS-Security 1.2, clause 9.8.3.1: the participant may then be admitted without authentication.
void Discovery::on_unauthenticated(const GuidPrefix& peer) {
  auto* remote = parts_.remotes.find(peer);
  const bool may = core_.security->admission().admits_unauthenticated() &&
                   !core_.security->dormant().contains(peer);
  if (remote != nullptr && may) links_.accept(*remote);
}

LocatorList Discovery::on_proven(const GuidPrefix& peer, const ParticipantData& proven) {
  auto* remote = parts_.remotes.find(peer);
  if (remote == nullptr) return usable(core_, proven.metatraffic_unicast);
  remote->has_returned = false;
  adopt_proven(remote->data, proven);
  remote->marks_ends = find_property(proven.properties, kMarksEndsProperty) != nullptr;
  remote->next_addresses.reset();  // they are older than these
  auto metatraffic = proven.metatraffic_unicast, user = proven.default_unicast;
  leave_out_loopback(core_, metatraffic);
  leave_out_loopback(core_, user);
  remote->has_signed_addresses =
      adopt_signed_addresses(core_, *remote, std::move(metatraffic), std::move(user));
  return remote->metatraffic;
}

void Discovery::on_unconfirmed(const GuidPrefix& peer) {
  auto* remote = parts_.remotes.find(peer);
  if (remote == nullptr || !switch_doubted_hosts(core_, *remote)) return;
  links_.limit_until_proven(*remote);
  links_.readdress(*remote);
}

void Discovery::on_replaced(const GuidPrefix& peer) {
  if (auto* remote = parts_.remotes.find(peer)) links_.unmatch(*remote);
}

bool Discovery::on_rights_changed(const GuidPrefix& peer) {
  auto* remote = parts_.remotes.find(peer);
  return remote != nullptr && parts_.matcher.match_all(*remote);
}

void Discovery::on_keys(const EntityId& local, const Guid& remote) {
  auto* participant = parts_.remotes.find(remote.prefix);
  if (participant == nullptr) return;
  if (is_builtin(local))
    builtin_.match(local, *participant);
  else
    parts_.matcher.match(local, remote);
}

}  // namespace ddssec::rtps
