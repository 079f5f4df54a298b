#include "rtps/participant/announcer.hpp"

#include <algorithm>

#include "rtps/security/leaving.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {
namespace {

constexpr MonotonicTime kAnnouncementPeriod = std::chrono::seconds(3);

}  // namespace

Announcer::Announcer(ParticipantCore& core, BuiltinEndpoints& builtin)
    : core_(core), builtin_(builtin) {}

ParticipantData Announcer::own_data() const {
  const auto& config = core_.config;
  ParticipantData own;
  own.guid = {config.prefix, kEntityIdParticipant};
  own.vendor = kVendorDdssec;
  own.domain_id = static_cast<std::uint32_t>(config.domain_id);
  own.domain_tag = config.domain_tag;
  own.builtin_endpoints =
      core_.security ? builtin_endpoints::kWithSecurity : builtin_endpoints::kWithoutSecurity;
  own.lease_duration = config.lease_duration;
  own.metatraffic_unicast = config.metatraffic_unicast;
  own.metatraffic_multicast = config.metatraffic_multicast;
  own.default_unicast = config.default_unicast;
  // If discovery is protected, the rest is sent only by DCPSParticipantsSecure.
  if (!core_.attributes().is_discovery_protected()) {
    own.entity_name = config.entity_name;
    own.user_data = config.user_data;
  }
  if (core_.security) {
    const auto& identity = core_.security->own();
    own.identity_token = identity.identity_token();
    own.permissions_token = identity.permissions_token();
    own.security_info = spi::security_info(identity.attributes());
    own.ciphers = identity.ciphers();
  }
  return own;
}

void Announcer::tick() {
  constexpr int kFastAnnouncements = 6;
  if (core_.now < next_) return;
  announce(core_.config.announce_to);
  last_ = core_.now;
  next_ = core_.now + (++announcements_ < kFastAnnouncements ? kFastPeriod : period());
}

// There are several announcements in each lease, so that the lease survives the loss of some.
MonotonicTime Announcer::period() const {
  constexpr int kInALease = 6;
  const auto share = core_.config.lease_duration.to_nanoseconds() / kInALease;
  const MonotonicTime wanted = core_.config.announcement_period;
  if (wanted > MonotonicTime::zero()) return std::min(wanted, share);
  return std::clamp<MonotonicTime>(share, kFastPeriod, kAnnouncementPeriod);
}

// If there is no budget for an answer, the next announcement to all is sent sooner. Otherwise it is
// repeated soon, because a participant may announce itself before it listens (Fast DDS 2.9).
void Announcer::answer(const GuidPrefix& participant, std::span<const Locator> metatraffic) {
  const bool room = answers_.try_spend(core_.now);
  if (room) announce(metatraffic, participant);
  next_ =
      std::min(next_, room ? core_.now + kRepeatDelay : std::max(core_.now, last_ + kMinPeriod));
}

void Announcer::announce_soon() {
  if (bursts_.try_spend(core_.now)) announce_often();
  next_ = std::min(next_, std::max(core_.now, last_ + kMinPeriod));
}

void Announcer::announce_again() {
  next_ = {};
  announce_securely();
}

// A participant may send to the first announced address whether it can reach it or not (Cyclone DDS
// 0.10). So each network receives only the local address in that network.
void Announcer::announce(std::span<const Locator> to, const GuidPrefix& charged) {
  const auto own = own_data();
  const auto& interfaces = core_.config.interfaces;
  if (interfaces.size() < 2) return announce(own, {.locators = to, .charged = charged});
  LocatorList elsewhere(to.begin(), to.end());
  for (std::size_t i = 0; i < interfaces.size(); ++i) {
    const auto& interface = interfaces[i];
    LocatorList here;
    for (const auto& locator : to)
      if (locator.is_multicast() || interface.reaches(locator)) here.push_back(locator);
    if (here.empty()) continue;
    const auto is_other = [&](const auto& l) { return l.address != interface.address.address; };
    auto data = own;
    std::erase_if(data.metatraffic_unicast, is_other);
    std::erase_if(data.default_unicast, is_other);
    announce(data, {.locators = here, .interface = i, .charged = charged});
    std::erase_if(elsewhere, [&](const auto& l) { return std::ranges::count(here, l) > 0; });
  }
  if (!elsewhere.empty()) announce(own, {.locators = elsewhere, .charged = charged});
}

void Announcer::announce(const ParticipantData& own, const Destination& to) {
  std::array<std::uint8_t, MessageSender::kMaxMessage> buffer;
  SpanWriter payload(buffer);
  write_payload(payload, own);
  const Data data{kSpdpReader, kSpdpWriter, {1}, {}, PayloadKind::data, payload.view()};
  core_.sender.add(to, data);
  core_.sender.flush();
}

void Announcer::announce_securely(bool leaving) {
  if (!core_.security) return;
  std::array<std::uint8_t, MessageSender::kMaxMessage> buffer;
  SpanWriter payload(buffer);
  const Guid guid{core_.config.prefix, kEntityIdParticipant};
  Change change;
  change.key_hash = guid.octets();
  change.is_key_only = leaving;
  if (leaving) {
    change.status = {true, true};
    write_participant_key(payload, guid);
  } else {
    auto own = own_data();
    own.entity_name = core_.config.entity_name;
    own.user_data = core_.config.user_data;
    write_payload(payload, own);
  }
  change.payload = Payload::copy_of(payload.view());
  builtin_.writer(BuiltinTopic::participants_secure).write(std::move(change), core_.now);
}

void Announcer::leave(const RemoteParticipants& remotes) {
  if (core_.security) announce_leaving(core_.security->core(), core_.security->exchange());
  announce_securely(true);
  std::array<std::uint8_t, 64> buffer;
  SpanWriter payload(buffer);
  const Guid guid{core_.config.prefix, kEntityIdParticipant};
  write_participant_key(payload, guid);
  // Fast DDS reads the instance only from the key hash.
  const Data data{kSpdpReader,      kSpdpWriter,   {2}, {guid.octets(), {true, true}},
                  PayloadKind::key, payload.view()};
  core_.sender.add({{}, core_.config.announce_to}, data);
  core_.sender.flush();
  for (const auto& [prefix, remote] : remotes.all()) {
    core_.sender.add({.locators = remote.metatraffic, .charged = prefix}, data);
    core_.sender.flush();
  }
}

}  // namespace ddssec::rtps
