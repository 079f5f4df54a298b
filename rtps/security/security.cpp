#include "rtps/security/security.hpp"

#include <algorithm>
#include <utility>

#include "rtps/security/leaving.hpp"
#include "rtps/security/memory_exchange.hpp"

namespace ddssec::rtps {
namespace {

// Tells the endpoints of revisions that came too often, and lets those of peers whose former keys
// have ended start again.
void end_former_keys(SecurityCore& core) {
  for (auto& [prefix, peer] : core.peers) {
    auto* association = peer.state.association();
    if (association == nullptr) continue;
    if (std::exchange(association->is_revision_untold, false))
      core.host.on_key_change({}, {prefix, {}}, KeyChange::revised);
    if (core.now < association->former_keys_end) continue;
    association->former_keys_end = kNever;
    core.host.on_key_change({}, {prefix, {}}, KeyChange::former_ended);
  }
}

struct BuiltinEndpoint {
  EntityId writer, reader;
  std::string_view topic;
  std::string_view writer_name = {}, reader_name = {};
};

// All builtin endpoints except the two pairs that must be readable before any peer is authenticated
// (DDS-Security 1.2, clause 7.5.8).
constexpr BuiltinEndpoint kBuiltin[] = {
    {kPublicationsWriter, kPublicationsReader, "DCPSPublication"},
    {kSubscriptionsWriter, kSubscriptionsReader, "DCPSSubscription"},
    {kParticipantMessageWriter, kParticipantMessageReader, "DCPSParticipantMessage"},
    {kPublicationsSecureWriter, kPublicationsSecureReader, "DCPSPublicationsSecure"},
    {kSubscriptionsSecureWriter, kSubscriptionsSecureReader, "DCPSSubscriptionsSecure"},
    {kParticipantsSecureWriter, kParticipantsSecureReader, "DCPSParticipantsSecure"},
    {kParticipantMessageSecureWriter, kParticipantMessageSecureReader,
     "DCPSParticipantMessageSecure"},
    {kVolatileMessageWriter, kVolatileMessageReader, "DCPSParticipantVolatileMessageSecure",
     "BuiltinParticipantVolatileMessageSecureWriter",
     "BuiltinParticipantVolatileMessageSecureReader"},
};

constexpr MonotonicTime kExpiryPeriod = std::chrono::seconds(1);

}  // namespace

Security::Security(std::unique_ptr<OwnSecurity> own, MessageSender& sender, TimerQueue& timers,
                   SecurityHost& host, EventSink& events)
    : core_(std::move(own), {sender, timers, host, events}, governance_change_) {
  listen_for_leaving(core_, exchange_);
  // The peer may have requested another handshake before the proof arrived.
  core_.own->session_ends().on_proven([this](const GuidPrefix& prefix, MonotonicTime now) {
    core_.set_now(now);
    if (auto* peer = core_.find(prefix)) handshakes_.end_probe(*peer);
  });
}

// Peers are removed one after the other, because each one flushes the messages that need its keys.
Security::~Security() {
  while (!core_.peers.empty()) core_.peers.erase(core_.peers.begin());
  while (!core_.dormant.empty()) core_.dormant.erase(core_.dormant.begin());
}

Status Security::start() {
  for (const auto& endpoint : kBuiltin) {
    DDSSEC_ASSIGN_OR_RETURN(const auto attributes, core_.own->builtin_attributes(endpoint.topic));
    DDSSEC_RETURN_IF_ERROR(
        core_.keyring.add_local(endpoint.writer, attributes, endpoint.writer_name));
    DDSSEC_RETURN_IF_ERROR(
        core_.keyring.add_local(endpoint.reader, attributes, endpoint.reader_name));
    admission_.note_builtin(endpoint.writer, endpoint.topic);
    admission_.note_builtin(endpoint.reader, endpoint.topic);
  }
  core_.sender.protect_with(core_.keyring);
  const auto& shared = core_.own->shared_memory();
  if (!shared.is_on) {
    exchange_.listen({message_class::kMemory}, [this](Peer& peer, const GenericMessage& message) {
      decline_memory(exchange_, peer, message);
    });
    return {};
  }
  auto memory = MemoryExchange::make(core_, exchange_, shared);
  if (memory)
    memory_ = *std::move(memory);
  else
    core_.events.raise(Event(Error(
        Code::rtps_memory_unused,
        {.document = "shared memory", .found = std::string(memory::to_string(memory.error()))})));
  return {};
}

// ---- peers

void Security::discovered(const ParticipantData& data, const AnnouncedAddresses& addresses,
                          MonotonicTime now) {
  core_.set_now(now);
  if (knows(data.guid.prefix)) return;
  handshakes_.add(data, addresses);
}

void Security::announced_again(const ParticipantData& data, const AnnouncedAddresses& addresses,
                               MonotonicTime now) {
  core_.set_now(now);
  handshakes_.announced_again(data, addresses);
}

// A peer that has left does not announce itself. So one that has proven the end of the session and
// still announces itself did not resume it. Announcements can be forged, but the end cannot.
void Security::note_announced(const GuidPrefix& prefix, MonotonicTime now) {
  constexpr auto kPatience = std::chrono::seconds(6);
  core_.set_now(now);
  auto* peer = core_.find(prefix);
  if (peer == nullptr) return;
  if (peer->state.joined() == nullptr) return handshakes_.note_announced(*peer);
  if (!core_.own->session_ends().remove_if_before(prefix, now - kPatience)) return;
  core_.raise(Error(Code::session_not_resumed,
                    {.document = "the session with participant " + peer->name(),
                     .expected = "that the peer authenticates us again",
                     .found = "no new session for " + std::to_string(kPatience.count()) + " s"}),
              *peer, EventOrigin::its_keys);
}

std::optional<Bytes> Security::lost(const GuidPrefix& prefix) {
  std::optional<Bytes> reset;
  if (auto* peer = core_.find(prefix)) {
    key_reviser_.note_absent(*peer);
    const auto* ended = peer->state.distrusted();
    if (ended != nullptr && ended->former && ended->former->reset)
      reset = spi::write_reset(core_.own->guid().prefix, *ended->former->reset);
  }
  handshakes_.remove(prefix);
  core_.peers.erase(prefix);
  // Removes pairs without keys. What is lost here is not the dormant peer, which has keys.
  if (!dormant_.contains(prefix)) core_.keyring.remove_remote(prefix);
  return reset;
}

bool Security::wake(const GuidPrefix& prefix) {
  auto peer = dormant_.take(prefix);
  return peer && handshakes_.wake(*std::move(peer));
}

bool Security::is_authenticated(const GuidPrefix& prefix) const {
  const auto* peer = core_.find(prefix);
  return peer != nullptr && peer->state.joined() != nullptr;
}

bool Security::has_proven_identity(const GuidPrefix& prefix) const {
  const auto* peer = core_.find(prefix);
  return peer != nullptr && peer->state.association() != nullptr;
}

bool Security::is_authenticating(const GuidPrefix& prefix) const {
  const auto* peer = core_.find(prefix);
  if (peer == nullptr) return false;
  const auto& state = peer->state;
  return state.is<peer::Announced>() || state.is<peer::Authenticating>() ||
         state.is<peer::AwaitingKeys>();
}

bool Security::has_spoken(const GuidPrefix& prefix) const {
  const auto* peer = core_.find(prefix);
  return peer != nullptr && peer->has_spoken;
}

void Security::on_stateless(const GuidPrefix& source, BytesView payload, MonotonicTime now) {
  core_.set_now(now);
  handshakes_.on_stateless(source, payload);
}

void Security::on_stateless_frag(const GuidPrefix& source, const DataFrag& frag,
                                 const SourceAddress& from, MonotonicTime now) {
  core_.set_now(now);
  handshakes_.on_stateless_frag(source, frag, from);
}

void Security::note_keys_acknowledged(const GuidPrefix& prefix) {
  auto* peer = core_.find(prefix);
  if (peer != nullptr && peer->state.association() != nullptr)
    exchange_.note_acknowledged(*peer);
  else
    dormant_.note_acknowledged(prefix);
}

void Security::note_key_exchange(const GuidPrefix& prefix) {
  if (auto* peer = core_.find(prefix)) handshakes_.note_key_exchange(*peer);
}

// ---- trust

void Security::distrust(const GuidPrefix& prefix) {
  key_reviser_.drop_absent(prefix, KeyReviser::RevisionReason::trust_lost);
  dormant_.distrust(prefix);
  auto* peer = core_.find(prefix);
  if (peer == nullptr) return;
  if (peer->state.association() != nullptr) key_reviser_.request();
  peer->state.on_trust_ended();
}

Status Security::revise_keys() {
  if (!key_reviser_.is_enabled()) return fail(Code::rtps_key_revision_disabled);
  key_reviser_.request();
  return {};
}

void Security::tick(MonotonicTime now) {
  core_.set_now(now);
  handshakes_.tick();
  exchange_.tick();
  // This comes before expire(). A revision that expire() requests begins in the next tick, when the
  // peers that have ended are removed.
  if (key_reviser_.is_busy()) change_.note_revision();
  key_reviser_.tick();
  if (memory_) memory_->serve(now);
  if (now >= next_expiry_) expire();
}

MonotonicTime Security::next_tick() const {
  return std::min({next_expiry_, key_reviser_.next_tick(), handshakes_.next_tick(),
                   exchange_.next_tick(), memory_ ? memory_->next_tick() : kNever});
}

template <class F>
std::vector<GuidPrefix> Security::peers_if(F&& ended) const {
  std::vector<GuidPrefix> out;
  for (const auto& [prefix, peer] : core_.peers) {
    const auto* handshake = peer.state.handshake();
    const auto* association = peer.state.association();
    const auto identity = handshake == nullptr ? nullptr : handshake->identity();
    if (ended(identity ? identity->handle() : spi::IdentityHandle{},
              association == nullptr ? spi::PermissionsHandle{} : association->permissions.handle))
      out.push_back(prefix);
  }
  return out;
}

// The plugins have the calendar and raise the events.
void Security::expire() {
  next_expiry_ = core_.now + kExpiryPeriod;
  end_former_keys(core_);
  auto& own = *core_.own;
  const auto identities = own.plugins().authentication.poll(own.identity());
  const auto permissions = own.plugins().access_control.poll(own.permissions());
  const bool rights_changed = own.present_renewed_permissions();
  const auto ended = [&](spi::IdentityHandle identity, spi::PermissionsHandle handle) {
    return (identity && std::ranges::find(identities, identity) != identities.end()) ||
           (handle && std::ranges::find(permissions, handle) != permissions.end());
  };
  const bool all = ended(own.identity(), own.permissions());
  const auto gone =
      peers_if([&](auto identity, auto handle) { return all || ended(identity, handle); });
  if (!all)
    for (const auto& prefix : gone) distrust(prefix);
  if (all) dormant_.drop_all();
  dormant_.distrust_if(ended);
  key_reviser_.poll_absent(ended);
  key_reviser_.poll_key_life();
  if (auto* const keys = own.pre_shared_keys()) keys->refresh();
  for (const auto& prefix : gone) core_.host.on_ended(prefix);
  if (all) return;
  for (const auto& prefix : renewal_.take_excluded()) {
    distrust(prefix);
    core_.host.on_ended(prefix);
  }
  dormant_.tick();
  if (rights_changed) {
    dormant_.drop_all();  // they may have keys of endpoints that they no longer match
    renewal_.on_own_rights_changed();
    handshakes_.try_all_again();
  }
  renewal_.offer_to_all();
  change_.tick();
  if (governance_change_.take_changed_domain()) handshakes_.try_all_again();
}

}  // namespace ddssec::rtps
