#include "rtps/security/security.hpp"

#include <algorithm>

namespace ddssec::rtps {
namespace {

struct BuiltinEndpoint {
  EntityId writer, reader;
  std::string_view topic;
  std::string_view writer_name = {}, reader_name = {};
};

// DDS-Security 7.4.5: all but the two that must be readable before anybody is authenticated.
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
    : own_(std::move(own)),
      sender_(sender),
      timers_(timers),
      host_(host),
      events_(events),
      keyring_(*own_, events) {}

Security::~Security() {
  while (!peers_.empty()) lost(GuidPrefix(peers_.begin()->first));
  forget_absent();
}

Status Security::start(Bytes own_data) {
  own_data_ = std::make_shared<const Bytes>(std::move(own_data));
  for (const auto& endpoint : kBuiltin) {
    const auto attributes = DDSSEC_TRY(own_->builtin_attributes(endpoint.topic));
    DDSSEC_TRY(keyring_.add_local(endpoint.writer, attributes, endpoint.writer_name));
    DDSSEC_TRY(keyring_.add_local(endpoint.reader, attributes, endpoint.reader_name));
  }
  sender_.protect_with(keyring_);
  return {};
}

Security::Peer* Security::find(const GuidPrefix& prefix) {
  const auto at = peers_.find(prefix);
  return at == peers_.end() ? nullptr : &at->second;
}

std::unique_ptr<PeerHandshake> Security::handshake_with(const ParticipantData& data,
                                                        MonotonicTime now) {
  return std::make_unique<PeerHandshake>(
      own_->plugins().authentication,
      PeerHandshake::Sides{own_->guid(), data.guid, own_->identity(),
                           data.identity_token.value_or(spi::Token{}),
                           data.vendor != kVendorFastDds},
      own_data_, numbers_, now);
}

void Security::discovered(const ParticipantData& data, const LocatorList& metatraffic,
                          MonotonicTime now) {
  now_ = now;
  const auto prefix = data.guid.prefix;
  if (peers_.contains(prefix)) return;
  drop_absent(prefix);
  look_after(
      peers_.emplace(prefix, Peer{data, metatraffic, handshake_with(data, now)}).first->second);
}

// Anybody may announce in anybody's name, and may have been the first. So a handshake that failed
// is begun anew with what is announced now, and one under way is carried on at both addresses.
void Security::announced_again(const ParticipantData& data, const LocatorList& metatraffic,
                               MonotonicTime now) {
  auto* peer = find(data.guid.prefix);
  if (peer == nullptr || peer->established) return;
  now_ = now;
  peer->metatraffic = metatraffic;
  if (!peer->refused || !starts_.take(now)) return;
  host_.on_replaced(GuidPrefix(data.guid.prefix));  // it may have been admitted without
  peer->handshake.reset();                          // gives the identity back
  peer->handshake = handshake_with(data, now);
  peer->data = data;
  peer->generation = 0;
  peer->refused = peer->admitted = false;
  look_after(*peer);
}

void Security::lost(const GuidPrefix& prefix) {
  const auto at = peers_.find(prefix);
  if (at == peers_.end()) return keyring_.remove_remote(prefix);
  note_absent(at->second);
  close(at->second);
  fragments_.forget(prefix);
  peers_.erase(at);
}

void Security::close(Peer& peer) {
  sender_.flush_now();  // what waits needs its keys
  keyring_.remove_remote(peer.data.guid.prefix);
  if (peer.permissions)
    static_cast<void>(own_->plugins().access_control.return_permissions_handle(peer.permissions));
  peer.permissions = {};
  peer.volatile_writer.reset();
  peer.volatile_reader.reset();
  peer.early.clear();
  peer.early_octets = 0;
  peer.established = peer.exchanges_keys = peer.authenticated = false;
  peer.doubted_until = kNever;
}

bool Security::is_authenticated(const GuidPrefix& prefix) const {
  const auto at = peers_.find(prefix);
  return at != peers_.end() && at->second.authenticated;
}

bool Security::is_authenticating(const GuidPrefix& prefix) const {
  const auto at = peers_.find(prefix);
  return at != peers_.end() && !at->second.authenticated && !at->second.refused &&
         !at->second.handshake->is_overdue();
}

bool Security::has_spoken(const GuidPrefix& prefix) const {
  const auto at = peers_.find(prefix);
  return at != peers_.end() && at->second.spoke;
}

// ---- handshake

// In a flood each of them has its own chance to be among those that are looked at.
void Security::send(Peer& peer, const PeerHandshake::Messages& messages) {
  for (const auto& message : messages) {
    const auto payload = write_generic_message(message);
    sender_.add({peer.data.guid.prefix, peer.metatraffic}, Data{kStatelessMessageReader,
                                                                kStatelessMessageWriter,
                                                                {++stateless_number_},
                                                                {},
                                                                PayloadKind::data,
                                                                payload});
    sender_.flush_now();
  }
}

void Security::on_stateless(const GuidPrefix& source, BytesView payload, MonotonicTime now) {
  now_ = now;
  auto* peer = find(source);
  if (peer == nullptr || peer->refused) return;
  const auto message = read_generic_message(payload);
  const bool ours = message && message->identity.source.prefix == source &&
                    message->destination_participant == own_->guid();
  if (!ours) return;
  peer->handshake->note_heard();
  if (!std::exchange(peer->spoke, true) && !peer->handshake->started())
    peer->handshake->start_at(now);
  if (message->message_class == message_class::kAuthRequest)
    on_auth_request(*peer);
  else if (message->message_class == message_class::kAuthentication)
    on_authentication(*peer, *message);
  look_after(*peer);
}

// It waits for our request. If we are done with it, it may have lost us; or somebody says so in its
// name, and it still answers by the keys that it has with us.
void Security::on_auth_request(Peer& peer) {
  if (!peer.handshake->begins()) return;
  if (!peer.established) return nudge(peer);
  if (!peer.authenticated || now_ < peer.next_second) return;
  peer.next_second = now_ + kSecondHandshake;
  peer.doubted_until = now_ + kDoubt;
  ask_over_volatile(peer);
}

void Security::end_doubt(Peer& peer) {
  peer.doubted_until = kNever;
  const bool answered = peer.volatile_writer && peer.volatile_writer->all_acknowledged();
  if (!answered && peer.authenticated && starts_.take(now_)) peer.handshake->begin_again(now_);
}

void Security::on_authentication(Peer& peer, const GenericMessage& message) {
  const auto weighed = peer.handshake->weigh(message);
  if (weighed.effort == Effort::none) return;
  PeerHandshake::Messages out;
  if (!may_spend(peer, weighed.effort) || !peer.handshake->receive(message, weighed, now_, out))
    return nudge(peer);
  if (peer.handshake->refusals() > 0 && !peer.established) note_failure(peer);
  // A Final goes out when the keys are ready for what the peer sends next.
  const bool newly = advance(peer);
  if (!peer.refused) send(peer, out);
  if (newly) open_volatile(peer, now_);
}

// Before anything is known to be true, public-key work is rationed. A flood leaves a ration to
// those who send little; in a flood that is in the name of an honest peer, its messages are taken
// as often as any other.
bool Security::may_spend(Peer& peer, Effort effort) {
  if (effort == Effort::memory) return repetitions_.take(now_);
  auto& ration = effort == Effort::echo ? echoes_ : requests_;
  const bool few = peer.few.take(now_) && !peer.failed;
  return (few ? ration.few : ration.loud).take(now_);
}

// Its next message may be the lucky one: it gets a reason to send it soon.
void Security::nudge(Peer& peer) {
  if (nudges_.take(now_)) peer.handshake->hasten(now_);
}

void Security::on_stateless_frag(const GuidPrefix& source, const DataFrag& frag,
                                 MonotonicTime now) {
  if (find(source) == nullptr) return;
  for (const auto& whole : fragments_.add(source, frag, now)) on_stateless(source, whole, now);
}

bool Security::advance(Peer& peer) {
  if (peer.refused) return false;
  if (peer.handshake->failure()) return refuse(peer);
  if (peer.handshake->generation() == peer.generation) return false;
  peer.generation = peer.handshake->generation();
  const bool had_keys = peer.established;
  if (std::exchange(peer.admitted, false) || had_keys)
    host_.on_replaced(GuidPrefix(peer.data.guid.prefix));
  if (had_keys) close(peer);
  if (auto status = establish(peer); !status) {
    if (had_keys) want_revision();
    return refuse(peer);
  }
  fragments_.forget(peer.data.guid.prefix);
  peer.since = now_;
  return peer.established = true;
}

bool Security::refuse(Peer& peer) {
  peer.refused = true;
  if (peer.established) want_revision();
  note_failure(peer);
  if (!peer.admitted) host_.on_refused(GuidPrefix(peer.data.guid.prefix));
  return false;
}

// DDS-Security 1.2, 9.8.3.1: a participant that could authenticate, and fails to, is matched as one
// that cannot. No single message is a failure: anybody can send it in the peer's name. And a peer
// that does not accept our certificate does not say so.
MonotonicTime Security::next_admission(const Peer& peer) const {
  const auto began = peer.handshake->began();
  const bool open = began && !peer.established && !peer.admitted && admits_unauthenticated();
  return open ? *began + kAdmissionPatience : kNever;
}

void Security::admit_meanwhile(Peer& peer) {
  peer.admitted = true;
  const auto guid = peer.data.guid.to_string();
  events_.raise(Event(
      Error(Code::rtps_admitted_unauthenticated,
            {.document = "participant " + guid,
             .field = "allow_unauthenticated_participants",
             .expected = "a handshake that succeeds within 3 s",
             .found = peer.handshake->refusals() > 0 ? "one whose messages were refused" : "none"}),
      {}, guid));
  host_.on_refused(GuidPrefix(peer.data.guid.prefix));
}

// No end: anybody can keep messages back, or forge them.
void Security::note_overdue(Peer& peer) {
  if (!peer.handshake->is_overdue() || std::exchange(peer.told_overdue, true)) return;
  note_failure(peer);
  const auto guid = peer.data.guid.to_string();
  events_.raise(Event(Error(Code::rtps_authentication_timeout,
                            {.document = "the handshake with participant " + guid,
                             .expected = "that it ends within 100 s",
                             .found = "no end",
                             .note = "it goes on, and is not told of again"}),
                      {}, guid));
}

void Security::note_failure(Peer& peer) {
  if (!std::exchange(peer.failed, true)) ++counters_.failed;
}

Status Security::establish(Peer& peer) {
  auto& [authentication, access_control, cryptography] = own_->plugins();
  DDSSEC_TRY(adopt_proven_data(peer));
  const auto handle = peer.handshake->handle();
  auto secret = DDSSEC_TRY(authentication.shared_secret(handle));
  const auto credential = DDSSEC_TRY(authentication.authenticated_peer_credential_token(handle));
  const auto identity = peer.handshake->peer_identity();
  peer.permissions = DDSSEC_TRY(access_control.validate_remote_permissions(
      own_->identity(), identity, peer.data.permissions_token.value_or(spi::Token{}), credential));
  DDSSEC_TRY(access_control.check_remote_participant(peer.permissions, own_->domain_id()));
  const auto prefix = peer.data.guid.prefix;
  DDSSEC_TRY(keyring_.add_remote(
      prefix, {identity, peer.permissions, std::move(secret), peer.data.vendor != kVendorCyclone}));
  DDSSEC_TRY(keyring_.introduce(kVolatileMessageWriter, {prefix, kVolatileMessageReader}));
  DDSSEC_TRY(keyring_.introduce(kVolatileMessageReader, {prefix, kVolatileMessageWriter}));
  return {};
}

// What was announced in the clear anybody could have said; this both sides have signed.
Status Security::adopt_proven_data(Peer& peer) {
  const auto proven = read_participant_list(peer.handshake->peer_data(), Endian::big);
  if (!proven || proven->guid != peer.data.guid)
    return {};  // without it, what was announced counts
  DDSSEC_TRY(check_participant(*proven));
  DDSSEC_TRY(check_domain(*proven));
  if (proven->vendor != VendorId{}) peer.data.vendor = proven->vendor;
  if (proven->permissions_token) peer.data.permissions_token = proven->permissions_token;
  if (auto proven_at = host_.on_proven(peer.data.guid.prefix, *proven); !proven_at.empty())
    peer.metatraffic = std::move(proven_at);
  return {};
}

// ---- time

void Security::tick(MonotonicTime now) {
  now_ = now;
  if (now >= next_handshake_) tick_handshakes();
  // Whom expire() finds is gone before keys are sent.
  tick_revision();
  if (now >= next_expiry_) expire();
}

void Security::look_after(const Peer& peer) {
  if (peer.refused) return;
  next_handshake_ = std::min(
      {next_handshake_, peer.handshake->next_tick(), peer.doubted_until, next_admission(peer)});
  if (peer.established && !peer.authenticated)
    next_handshake_ = std::min(
        next_handshake_, peer.since + (needs_no_tokens(peer) ? kTokenPatience : kConfirmation));
}

// A peer may go meanwhile.
void Security::tick_handshakes() {
  next_handshake_ = kNever;
  for (auto at = peers_.begin(); at != peers_.end();) {
    const auto prefix = at->first;
    if (!at->second.refused) tick_handshake(at->second, now_);
    if (const auto* peer = find(prefix)) look_after(*peer);
    at = peers_.upper_bound(prefix);
  }
}

void Security::tick_handshake(Peer& peer, MonotonicTime now) {
  auto& handshake = *peer.handshake;
  if (now >= peer.doubted_until) end_doubt(peer);
  if (now >= next_admission(peer)) admit_meanwhile(peer);
  if (needs_no_tokens(peer) && now >= peer.since + kTokenPatience) note_authenticated(peer);
  if (peer.established && !peer.authenticated && now >= peer.since + kConfirmation) {
    peer.since = now;
    handshake.begin_again(now);
  }
  if (now < handshake.next_tick()) return;
  // Announcements cost their sender nothing, and words little; keys cost us something.
  auto& starts = peer.spoke ? spoken_starts_ : starts_;
  if (!handshake.started() && !starts.take(now)) return handshake.start_at(now + kStartPeriod);
  const bool is_silent = handshake.started() && !peer.spoke;
  if (is_silent && !silent_.take(now)) return handshake.start_at(now + PeerHandshake::kResend);
  PeerHandshake::Messages out;
  handshake.tick(now, out);
  note_overdue(peer);
  send(peer, out);
  advance(peer);
}

MonotonicTime Security::next_tick() const {
  return std::min({next_expiry_, next_revision(), next_handshake_});
}

// The plugins know the calendar and raise the events.
void Security::expire() {
  next_expiry_ = now_ + kExpiryPeriod;
  const auto identities = own_->plugins().authentication.expire(own_->identity());
  const auto permissions = own_->plugins().access_control.expire(own_->permissions());
  const auto ended = [&](spi::IdentityHandle identity, spi::PermissionsHandle handle) {
    return (identity && std::ranges::find(identities, identity) != identities.end()) ||
           (handle && std::ranges::find(permissions, handle) != permissions.end());
  };
  std::vector<GuidPrefix> gone;
  const bool all = ended(own_->identity(), own_->permissions());
  for (auto& [prefix, peer] : peers_)
    if (all || ended(peer.handshake->peer_identity(), peer.permissions)) {
      gone.push_back(prefix);
      if (!all) distrust(prefix);
    }
  for (const auto& absent : absent_)
    if (ended(absent.handshake->peer_identity(), absent.permissions)) want_revision();
  if (revises()) {
    keyring_.forget_former_keys();
    if (keyring_.is_revision_due()) want_revision();
  }
  if (auto* const keys = own_->pre_shared_keys()) keys->refresh();
  for (const auto& prefix : gone) host_.on_ended(prefix);
}

}  // namespace ddssec::rtps
