// The legal transitions. All others are refused and change nothing.
//
//   Announced       --HandshakeBegun--------->  Authenticating
//   Announced       --HandshakeTimeout------->  Waiting         after 100 s: retries slowly
//   Authenticating  --HandshakeTimeout------->  Waiting         after 100 s
//   Authenticating  --AdmissionTimeout------->  Authenticating  after 3 s, if strangers are allowed
//   Waiting         --AdmissionTimeout------->  Waiting         after 3 s, if strangers are allowed
//   Authenticating  --HandshakeFinished------>  Authenticating  what was agreed on before ends
//   Waiting         --HandshakeFinished------>  Authenticating
//   AwaitingKeys    --HandshakeFinished------>  Authenticating
//   Joined          --HandshakeFinished------>  Authenticating
//   Authenticating  --PermissionsValidated--->  AwaitingKeys    keys registered
//   AwaitingKeys    --KeyExchangeMessage----->  AwaitingKeys
//   AwaitingKeys    --KeysTimeout------------>  AwaitingKeys    after 10 s: requests a handshake
//   AwaitingKeys    --ParticipantTokens------>  Joined
//   Joined          --AuthRequest------------>  Joined          probes the peer by its keys
//   Joined          --ProbeEnded------------->  Joined
//   Announced       --Refusal---------------->  Refused
//   Authenticating  --Refusal---------------->  Refused
//   Waiting         --Refusal---------------->  Refused
//   AwaitingKeys    --Refusal---------------->  Refused         its keys could not be made
//   Refused         --AnotherAnnouncement---->  Announced       also after 5 s to 60 s
//   any other       --TrustEnded------------->  Distrusted      keys stay until it is unmatched
//
// AdmissionTimeout lets the peer take part without authentication. A refused peer is tried again
// after a time, because documents may have been renewed. TrustEnded: identity or permissions of the
// peer, or our own ones, have expired or were revoked.
//
// No transition leaves Distrusted: the participant is removed. Announcements and forged messages,
// which prove nothing, lead only to Authenticating, to Waiting or to a probe. They lead to Refused
// if the announced identity token is invalid; a different announcement leads back from there.
#include "rtps/security/peer.hpp"

namespace ddssec::rtps {
namespace {

using peer::Announced;
using peer::Authenticating;
using peer::AwaitingKeys;
using peer::Distrusted;
using peer::Joined;
using peer::Refused;
using peer::Unproven;
using peer::Waiting;

// The events that cause transitions.
struct HandshakeBegun {};
struct HandshakeTimeout {};
struct AdmissionTimeout {};
struct HandshakeFinished {};
struct PermissionsValidated {
  Association association;
  MonotonicTime now;
};
struct KeyExchangeMessage {};
struct KeysTimeout {
  MonotonicTime now;
};
struct ParticipantTokens {};
struct AuthRequest {
  MonotonicTime deadline, next;
};
struct ProbeEnded {};
struct Refusal {
  bool admits;
};
struct AnotherAnnouncement {
  std::unique_ptr<PeerHandshake> handshake;
};
struct TrustEnded {};

// Result of a transition that stays in the same state.
struct Stays {};
// Result if there is no transition.
struct Illegal {};

// The state object stays the same, apart from what `on` changed in it.
constexpr Stays kStays;

Authenticating on(Announced& state, const HandshakeBegun&) { return {std::move(state)}; }

Waiting on(Announced& state, const HandshakeTimeout&) { return {std::move(state)}; }
Waiting on(Authenticating& state, const HandshakeTimeout&) { return {std::move(state)}; }

Stays on(Authenticating& state, const AdmissionTimeout&) {
  state.is_admitted = true;
  return kStays;
}
Stays on(Waiting& state, const AdmissionTimeout&) {
  state.is_admitted = true;
  return kStays;
}

Stays on(Authenticating&, const HandshakeFinished&) { return kStays; }
Authenticating on(Waiting& state, const HandshakeFinished&) { return {std::move(state)}; }
Authenticating on(AwaitingKeys& state, const HandshakeFinished&) {
  return {{std::move(state.association.handshake)}};
}
Authenticating on(Joined& state, const HandshakeFinished&) {
  return {{std::move(state.association.handshake)}};
}

AwaitingKeys on(Authenticating& state, PermissionsValidated& event) {
  event.association.handshake = std::move(state.handshake);
  return {std::move(event.association), event.now};
}

Stays on(AwaitingKeys& state, const KeyExchangeMessage&) {
  state.exchanges_keys = true;
  return kStays;
}
Stays on(AwaitingKeys& state, const KeysTimeout& event) {
  state.since = event.now;
  return kStays;
}
Joined on(AwaitingKeys& state, const ParticipantTokens&) { return {std::move(state.association)}; }

Stays on(Joined& state, const AuthRequest& event) {
  state.next_probe = event.next;
  state.probe_deadline = event.deadline;
  return kStays;
}
Stays on(Joined& state, const ProbeEnded&) {
  state.probe_deadline = kNever;
  return kStays;
}

Refused on(Announced&, const Refusal& event) { return {event.admits}; }
Refused on(Authenticating&, const Refusal& event) { return {event.admits}; }
Refused on(Waiting&, const Refusal& event) { return {event.admits}; }
Refused on(AwaitingKeys&, const Refusal& event) { return {event.admits}; }

Announced on(Refused& state, AnotherAnnouncement& event) {
  return {{std::move(event.handshake), state.admits}};
}

// Closes the channel: from now on nothing is sent to the peer, or accepted from it.
Distrusted without_channel(Association& association) {
  association.volatile_writer.reset();
  association.volatile_reader.reset();
  return {std::move(association)};
}

Distrusted on(Announced&, const TrustEnded&) { return {}; }
Distrusted on(Authenticating&, const TrustEnded&) { return {}; }
Distrusted on(Waiting&, const TrustEnded&) { return {}; }
Distrusted on(AwaitingKeys& state, const TrustEnded&) { return without_channel(state.association); }
Distrusted on(Joined& state, const TrustEnded&) { return without_channel(state.association); }
Distrusted on(Refused&, const TrustEnded&) { return {}; }

// All other combinations.
Illegal on(auto&, const auto&) { return {}; }

}  // namespace

PeerState::PeerState(std::unique_ptr<PeerHandshake> handshake)
    : state_(Announced{{std::move(handshake)}}) {}

// The new state is entered before the former one is destroyed and releases what it owned.
template <class Event>
bool PeerState::apply(Event&& event) {
  return std::visit(
      [&](auto& current) {
        auto next = on(current, event);
        using Next = decltype(next);
        if constexpr (std::is_same_v<Next, Illegal>) {
          return false;
        } else if constexpr (!std::is_same_v<Next, Stays>) {
          const auto former = std::exchange(state_, State(std::move(next)));
        }
        return true;
      },
      state_);
}

bool PeerState::on_handshake_begun() { return apply(HandshakeBegun{}); }
bool PeerState::on_handshake_timeout() { return apply(HandshakeTimeout{}); }
bool PeerState::on_admission_timeout() { return apply(AdmissionTimeout{}); }
bool PeerState::on_handshake_finished() { return apply(HandshakeFinished{}); }
bool PeerState::on_permissions_validated(Association association, MonotonicTime now) {
  return apply(PermissionsValidated{std::move(association), now});
}
bool PeerState::on_key_exchange_message() { return apply(KeyExchangeMessage{}); }
bool PeerState::on_keys_timeout(MonotonicTime now) { return apply(KeysTimeout{now}); }
bool PeerState::on_participant_tokens() { return apply(ParticipantTokens{}); }
bool PeerState::on_auth_request(MonotonicTime deadline, MonotonicTime next) {
  return apply(AuthRequest{deadline, next});
}
bool PeerState::on_probe_ended() { return apply(ProbeEnded{}); }
bool PeerState::on_refusal(bool admits) { return apply(Refusal{admits}); }
bool PeerState::on_another_announcement(std::unique_ptr<PeerHandshake> handshake) {
  return apply(AnotherAnnouncement{std::move(handshake)});
}
bool PeerState::on_trust_ended() { return apply(TrustEnded{}); }

const Unproven* PeerState::unproven() const {
  return std::visit(
      [](const auto& state) -> const Unproven* {
        if constexpr (requires { state.is_admitted; }) return &state;
        return nullptr;
      },
      state_);
}

bool PeerState::is_admitted() const {
  if (const auto* refused = std::get_if<Refused>(&state_)) return refused->admits;
  const auto* state = unproven();
  return state != nullptr && state->is_admitted;
}

PeerHandshake* PeerState::handshake() const {
  if (const auto* state = unproven()) return state->handshake.get();
  const auto* proven = association();
  return proven == nullptr ? nullptr : proven->handshake.get();
}

const Association* PeerState::association() const {
  return std::visit(
      [](const auto& state) -> const Association* {
        if constexpr (requires { state.association; }) return &state.association;
        return nullptr;
      },
      state_);
}

Association* PeerState::association() {
  return std::visit(
      [](auto& state) -> Association* {
        if constexpr (requires { state.association; }) return &state.association;
        return nullptr;
      },
      state_);
}

}  // namespace ddssec::rtps
