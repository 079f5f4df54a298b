// Participant, the half that finds other participants (RTPS 8.5.3).
#include <algorithm>

#include "rtps/participant/participant.hpp"

namespace ddssec::rtps {
namespace {

constexpr MonotonicTime kAnnouncementPeriod = std::chrono::seconds(3);

KeyHash key_of(const Guid& guid) { return guid.octets(); }

/// The first few stay, of the others the latest.
void add_locators(LocatorList& known, const LocatorList& more) {
  constexpr std::size_t kMost = 8;
  for (const auto& locator : more) {
    if (std::ranges::find(known, locator) != known.end()) continue;
    if (known.size() >= kMost) known.erase(known.begin() + kMost / 2);
    known.push_back(locator);
  }
}

}  // namespace

// An announcement may name any address; only what one can send to, and little of it, is used.
LocatorList usable_locators(const LocatorList& announced, const LocatorList& fallback,
                            std::span<const NetworkInterface> own) {
  constexpr std::size_t kMostUsed = 4;
  LocatorList out;
  for (const auto& locator : announced)
    if (locator.is_usable() && !locator.is_multicast()) out.push_back(locator);
  keep_nearest(out, own);
  if (out.size() > kMostUsed) out.resize(kMostUsed);
  return out.empty() ? fallback : out;
}

MonotonicTime lease_end(const ParticipantData& data, MonotonicTime now) {
  const auto lease = data.lease_duration.to_nanoseconds();
  return data.lease_duration.is_infinite() ? kNever : now + lease;
}

ParticipantData Participant::own_data() const {
  ParticipantData own;
  own.guid = {config_.prefix, kEntityIdParticipant};
  own.vendor = kVendorDdssec;
  own.domain_id = static_cast<std::uint32_t>(config_.domain_id);
  own.domain_tag = config_.domain_tag;
  own.builtin_endpoints =
      security_ ? builtin_endpoints::kWithSecurity : builtin_endpoints::kWithoutSecurity;
  own.lease_duration = config_.lease_duration;
  own.metatraffic_unicast = config_.metatraffic_unicast;
  own.metatraffic_multicast = config_.metatraffic_multicast;
  own.default_unicast = config_.default_unicast;
  // Where discovery is protected the rest is for DCPSParticipantsSecure alone.
  if (!security_ || !security_->own().attributes().is_discovery_protected()) {
    own.entity_name = config_.entity_name;
    own.user_data = config_.user_data;
  }
  if (security_) {
    own.identity_token = security_->own().identity_token();
    own.permissions_token = security_->own().permissions_token();
    own.security_info = spi::security_info(security_->own().attributes());
    own.ciphers = security_->own().ciphers();
  }
  return own;
}

// A participant may send to the first address that is announced, whether it leads to us or not
// (Cyclone DDS 0.10): in each network it hears of our address there alone.
void Participant::announce(std::span<const Locator> to) {
  const auto own = own_data();
  if (config_.interfaces.size() < 2) return announce(own, to, kEveryInterface);
  LocatorList elsewhere(to.begin(), to.end());
  for (std::size_t i = 0; i < config_.interfaces.size(); ++i) {
    const auto& interface = config_.interfaces[i];
    LocatorList here;
    for (const auto& locator : to)
      if (locator.is_multicast() || interface.reaches(locator)) here.push_back(locator);
    if (here.empty()) continue;
    const auto is_other = [&](const auto& l) { return l.address != interface.address.address; };
    auto data = own;
    std::erase_if(data.metatraffic_unicast, is_other);
    std::erase_if(data.default_unicast, is_other);
    announce(data, here, i);
    std::erase_if(elsewhere, [&](const auto& l) { return std::ranges::count(here, l) > 0; });
  }
  if (!elsewhere.empty()) announce(own, elsewhere, kEveryInterface);
}

void Participant::announce(const ParticipantData& own, std::span<const Locator> to,
                           std::size_t interface) {
  std::array<std::uint8_t, MessageSender::kLargestMessage> buffer;
  SpanWriter payload(buffer);
  write_payload(payload, own);
  const Data data{kSpdpReader, kSpdpWriter, {1}, {}, PayloadKind::data, payload.view()};
  sender_.add({.locators = to, .interface = interface}, data);
  sender_.flush();
}

// Several in each lease, so that lost ones do not end it.
MonotonicTime Participant::announcement_period() const {
  constexpr int kInALease = 6;
  const auto share = config_.lease_duration.to_nanoseconds() / kInALease;
  const MonotonicTime wanted = config_.announcement_period;
  if (wanted > MonotonicTime::zero()) return std::min(wanted, share);
  return std::clamp<MonotonicTime>(share, kFastPeriod, kAnnouncementPeriod);
}

void Participant::leave() {
  announce_securely(true);
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

Status Participant::on_announcement(const GuidPrefix& source, const Data& data) {
  if (data.inline_qos.status != StatusInfo{} || data.kind == PayloadKind::key) {
    const auto guid = data.inline_qos.key_hash
                          ? GuidPrefix::from(BytesView(*data.inline_qos.key_hash).first(12))
                          : DDSSEC_TRY(read_participant_key(data.payload)).prefix;
    if (guid == source) on_dispose(guid);
    return {};
  }
  if (data.kind != PayloadKind::data) return {};
  auto announced = DDSSEC_TRY(read_participant_data(data.payload));
  const bool ours = is_of_domain(announced, config_.domain_id, config_.domain_tag);
  if (!ours || announced.guid.prefix == config_.prefix) return {};
  if (announced.guid.prefix != source) {
    ++counters_.refused_discovery;
    return {};
  }
  add_remote(std::move(announced), now_);
  return {};
}

// Only itself can say that a participant is gone; once it is authenticated only by the secure
// topic. Fast DDS does not have that, so it is taken at its word if it keeps silent from now on.
void Participant::on_dispose(const GuidPrefix& prefix) {
  const auto known = remotes_.find(prefix);
  if (known == remotes_.end()) return;
  auto& remote = known->second;
  const bool proven = is_authenticated(prefix);
  if (proven && remote.data.vendor == kVendorFastDds)
    next_lease_ =
        std::min(next_lease_, remote.lease_end = std::min(remote.lease_end, now_ + kDoubt));
  else if (proven || (security_ && security_->is_authenticating(prefix)))
    ++counters_.refused_discovery;
  else
    gone_.push_back(prefix);
}

void Participant::add_remote(ParticipantData data, MonotonicTime now) {
  const auto prefix = data.guid.prefix;
  if (ignored_.participants.contains(prefix)) return;
  if (const auto known = remotes_.find(prefix); known != remotes_.end())
    return on_known(known->second, std::move(data), now);
  auto metatraffic = usable_locators(data.metatraffic_unicast, {}, config_.interfaces);
  if (metatraffic.empty() || (remotes_.size() >= kMostParticipants && !make_room())) {
    ++counters_.refused_discovery;
    return;
  }
  auto user = usable_locators(data.default_unicast, metatraffic, config_.interfaces);
  const auto end = lease_end(data, now);
  next_lease_ = std::min(next_lease_, end);
  const auto verdict =
      security_ ? security_->judge(data) : Security::Verdict::admit_unauthenticated;
  auto& remote =
      remotes_[prefix] = {std::move(data), std::move(metatraffic), std::move(user), end, now};
  // Too many at once are all told the way that we chose ourselves; the others once more soon: a
  // participant may announce itself before it listens (Fast DDS 2.9).
  const bool room = answers_.take(now);
  if (room) announce(remote.metatraffic);
  next_announcement_ = std::min(
      next_announcement_, room ? now + kRepeatDelay : std::max(now, last_announcement_ + kHurry));
  if (security_) silent_.push_back(prefix);
  if (silent_.size() > 4 * kMostParticipants) silent_.pop_front();
  if (verdict == Security::Verdict::authenticate)
    security_->discovered(remote.data, remote.metatraffic, now);
  renew_lease(remote, remote.data, now);
  if (verdict == Security::Verdict::admit_unauthenticated) match_builtin(remote);
}

// Of those that proved nothing the one that only announced itself longest ago goes, or else the one
// whose handshake takes longest. Without security nobody can prove anything.
bool Participant::make_room() {
  if (!security_) return false;
  auto victim = remotes_.end();
  for (; victim == remotes_.end() && !silent_.empty(); silent_.pop_front())
    if (!security_->has_spoken(silent_.front())) victim = remotes_.find(silent_.front());
  if (victim == remotes_.end()) victim = oldest_unproven();
  if (victim == remotes_.end()) return false;
  ++counters_.refused_discovery;
  remove_remote(GuidPrefix(victim->first));
  return true;
}

// Until it has proven itself its lease is at least one in which it could have.
void Participant::renew_lease(Remote& remote, const ParticipantData& data, MonotonicTime now) {
  const auto end = lease_end(data, now);
  const bool proven = !security_ || !security_->is_authenticating(data.guid.prefix);
  remote.lease_end = proven ? end : std::max({remote.lease_end, end, now + kLeastLease});
  next_lease_ = std::min(next_lease_, remote.lease_end);
}

std::map<GuidPrefix, Participant::Remote>::iterator Participant::oldest_unproven() {
  auto oldest = remotes_.end();
  for (auto at = remotes_.begin(); at != remotes_.end(); ++at)
    if (!security_->is_authenticated(at->first) &&
        (oldest == remotes_.end() || at->second.since < oldest->second.since))
      oldest = at;
  return oldest;
}

// What was authenticated stays as it was: anybody can send announcements in its name. And anybody
// may have been the first to do so: as long as nothing is proven, all that is announced counts, and
// no lease becomes shorter.
void Participant::on_known(Remote& remote, ParticipantData data, MonotonicTime now) {
  const auto prefix = data.guid.prefix;
  const bool fixed = security_ && security_->is_authenticated(prefix);
  renew_lease(remote, fixed ? remote.data : data, now);
  if (!fixed && remote.accepted && remote.data.user_data != data.user_data) {
    remote.data.user_data = data.user_data;
    tell_of(remote);
  }
  if (fixed || !security_ || data == remote.data || !security_->may_authenticate(data)) return;
  if (!security_->knows(prefix)) {
    remove_remote(prefix);
    return add_remote(std::move(data), now);
  }
  add_locators(remote.metatraffic,
               usable_locators(data.metatraffic_unicast, {}, config_.interfaces));
  add_locators(remote.user, usable_locators(data.default_unicast, {}, config_.interfaces));
  security_->announced_again(data, remote.metatraffic, now);
}

void Participant::match_builtin(Remote& remote) {
  accept(remote);
  builtin_.each([&](const auto& info, auto&, auto&) {
    match_builtin(info, remote, true);
    match_builtin(info, remote, false);
  });
}

void Participant::match_builtin(const BuiltinTopicInfo& info, Remote& remote, bool with_writer) {
  const auto& prefix = remote.data.guid.prefix;
  if (info.topic == BuiltinTopic::participants_secure && remote.data.vendor == kVendorFastDds &&
      !remote.heard_participants_secure)
    return;
  // The reader of a pair is the bit above its writer.
  const auto mask = with_writer ? 0xaaaaaaaau : 0x55555555u;
  if ((remote.data.builtin_endpoints & info.bits & mask) == 0) return;
  const EntityId own = with_writer ? info.writer : info.reader;
  const Guid other{prefix, with_writer ? info.reader : info.writer};
  if (security_ && !security_->introduce(own, other)) return;
  if (with_writer)
    builtin_.writer(info.topic).match({other, true, true, remote.metatraffic}, now_);
  else
    builtin_.find_reader(own)->match({other, true, remote.metatraffic}, now_);
}

// Fast DDS announces DCPSParticipantsSecure. Up to 2.9 it does not have it; later it has, and takes
// part in nothing else until it has our data from there. So it is matched once it is heard there.
void Participant::note_participants_secure(const GuidPrefix& peer) {
  const auto at = remotes_.find(peer);
  if (at == remotes_.end() || std::exchange(at->second.heard_participants_secure, true)) return;
  auto& remote = at->second;
  if (!remote.accepted || remote.data.vendor != kVendorFastDds) return;
  for (const auto& info : kBuiltinTopics) {
    if (info.topic != BuiltinTopic::participants_secure) continue;
    match_builtin(info, remote, true);
    match_builtin(info, remote, false);
  }
}

// Leases grow with everything that is heard: the time that was noted may be too early, never too
// late.
void Participant::remove_ended(MonotonicTime now) {
  if (now < next_lease_) return;
  next_lease_ = kNever;
  for (const auto& [prefix, remote] : remotes_) {
    if (remote.lease_end <= now)
      gone_.push_back(prefix);
    else
      next_lease_ = std::min(next_lease_, remote.lease_end);
  }
}

void Participant::unmatch(Remote& remote) {
  const auto prefix = remote.data.guid.prefix;
  remote.watches.clear();
  while (!remote.endpoints.empty()) remove_endpoint(remote, remote.endpoints.begin()->first);
  builtin_.each([&](const auto& info, auto& writer, auto& reader) {
    writer.unmatch({prefix, info.reader});
    reader.unmatch({prefix, info.writer});
  });
}

void Participant::remove_remote(const GuidPrefix& prefix) {
  const auto at = remotes_.find(prefix);
  if (at == remotes_.end()) return;
  unmatch(at->second);
  if (security_) security_->lost(prefix);
  if (at->second.accepted && discovery_ != nullptr)
    discovery_->on_participant_gone(at->second.data.guid);
  remotes_.erase(at);
}

}  // namespace ddssec::rtps
