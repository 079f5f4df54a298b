// One remote participant that may authenticate, as a state machine. The legal edges stand at the
// top of peer.cpp.
#pragma once

#include <functional>
#include <string>
#include <variant>

#include "rtps/budget/source_address.hpp"
#include "rtps/budget/work_budget.hpp"
#include "rtps/discovery/participant_data.hpp"
#include "rtps/reliability/stateful_reader.hpp"
#include "rtps/security/early_tokens.hpp"
#include "rtps/security/peer_handshake.hpp"
#include "rtps/security/waiting_tokens.hpp"

namespace ddssec::rtps {

/// Calls a function when its owner dies, once.
class Cleanup {
 public:
  Cleanup() = default;
  explicit Cleanup(std::function<void()> call) : call_(std::move(call)) {}
  Cleanup(Cleanup&& other) noexcept : call_(std::exchange(other.call_, nullptr)) {}
  Cleanup& operator=(Cleanup&& other) noexcept {
    std::swap(call_, other.call_);
    return *this;
  }
  ~Cleanup() {
    if (call_) call_();
  }

 private:
  std::function<void()> call_;
};

/// A handle of access control, and what returns it.
struct PeerPermissions {
  spi::PermissionsHandle handle = {};
  Cleanup give_back = {};
};

/// What we share with a peer that proved its identity. The members die in reverse order: the keys
/// first, then the permissions and the identity that the keys were made for.
struct Association {
  std::unique_ptr<PeerHandshake> handshake = {};  ///< finished; another one may run beside it
  PeerPermissions permissions = {};
  std::string subject = {};  ///< of its certificate
  Cleanup place = {};        ///< gives back its share of the places for its certificate
  EarlyTokens early = {};
  WaitingTokens waiting = {};
  std::unique_ptr<StatefulReader> volatile_reader = {};
  std::unique_ptr<StatefulWriter> volatile_writer = {};
  Cleanup keys = {};  ///< removes them from the keyring
};

/// Each state owns what it needs: leaving a state gives that back.
namespace peer {

/// Nothing is proven. `admitted`: it takes part without authentication until it succeeds.
struct Unproven {
  std::unique_ptr<PeerHandshake> handshake;
  bool admitted = false;
};
/// Heard of; nothing was spent on it.
struct Announced : Unproven {};
/// Its identity token is valid, and handshake messages come and go.
struct Authenticating : Unproven {};
/// The handshake took too long. It goes on at a slow pace, as nothing proves that it is hopeless.
struct Waiting : Unproven {};
/// Authenticated and permitted; its participant key is not here yet.
struct AwaitingKeys {
  Association association;
  MonotonicTime since{};        ///< of the handshake, or of the last one that was asked for
  bool exchanges_keys = false;  ///< it has shown that it has the shared secret
};
/// Its participant key is here, or none is needed.
struct Joined {
  Association association;
  MonotonicTime next_probe{};             ///< no probe before
  MonotonicTime probe_deadline = kNever;  ///< of the probe under way
};
/// A signed document says that it may not join, or its identity token is invalid. Only another
/// announcement gives it another try.
struct Refused {};
/// Its trust has ended. Keeps its keys registered, unused, until its endpoints are unmatched.
struct Distrusted {
  std::optional<Association> former;
};

}  // namespace peer

/// An edge that is not legal in the current state returns false and changes nothing.
class PeerState {
 public:
  explicit PeerState(std::unique_ptr<PeerHandshake> handshake);

  // Edges, in the order of the list in peer.cpp.
  bool begin();
  bool time_out();
  bool admit_unauthenticated();
  /// A handshake was finished: whatever was agreed on before ends here.
  bool replace();
  /// `association`: without its handshake, which comes from the state that is left.
  bool associate(Association association, MonotonicTime now);
  bool note_key_exchange();
  /// The keys did not come: another handshake was asked for.
  bool ask_again(MonotonicTime now);
  bool join();
  bool probe(MonotonicTime deadline, MonotonicTime next);
  bool end_probe();
  bool refuse();
  bool announce_again(std::unique_ptr<PeerHandshake> handshake);
  bool distrust();

  template <class S>
  bool is() const {
    return std::holds_alternative<S>(state_);
  }
  /// nullptr: it is in another state.
  const peer::AwaitingKeys* awaiting_keys() const {
    return std::get_if<peer::AwaitingKeys>(&state_);
  }
  const peer::Joined* joined() const { return std::get_if<peer::Joined>(&state_); }
  const peer::Unproven* unproven() const;
  bool is_admitted() const;
  /// nullptr where no message of a handshake counts.
  PeerHandshake* handshake() const;
  /// nullptr: it is not authenticated, or not trusted any more.
  Association* association();
  const Association* association() const;

 private:
  template <class Event>
  bool take(Event&& event);

  using State = std::variant<peer::Announced, peer::Authenticating, peer::Waiting,
                             peer::AwaitingKeys, peer::Joined, peer::Refused, peer::Distrusted>;
  State state_;
};

/// A participant that was announced as one that can authenticate.
struct Peer {
  ParticipantData data;
  LocatorList metatraffic;
  PeerState state;
  WorkBudget few;             ///< handshake messages of it that count as few
  SourceAddress source = {};  ///< of its latest announcement
  /// The source that announced each address of `metatraffic`.
  std::vector<SourceAddress> announced_by = {};
  bool was_announced = true;  ///< since a message was repeated to it
  /// Octets of a message that waits until so many may be sent to it; 0: there is none.
  std::size_t held_back = 0;
  bool may_go_on = false;  ///< what was held back may be sent now
  /// Octets that answers to our questions will allow to send for it.
  std::size_t expected = 0;
  bool spoke = false;   ///< sent a handshake message once
  bool failed = false;  ///< something of it was refused, and that was counted

  const GuidPrefix& prefix() const { return data.guid.prefix; }
  std::string name() const { return data.guid.to_string(); }
};

}  // namespace ddssec::rtps
