// One remote participant that may authenticate, as a state machine. The legal transitions are
// listed at the top of peer.cpp.
#pragma once

#include <functional>
#include <string>
#include <variant>

#include "plugins/spi/access_control.hpp"
#include "plugins/spi/session_reset.hpp"
#include "rtps/budget/source_address.hpp"
#include "rtps/budget/work_budget.hpp"
#include "rtps/discovery/participant_data.hpp"
#include "rtps/reliability/stateful_reader.hpp"
#include "rtps/security/early_tokens.hpp"
#include "rtps/security/peer_handshake.hpp"
#include "rtps/security/waiting_tokens.hpp"

namespace ddssec::rtps {

/// Calls a function once, in its destructor.
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

/// A handle of access control, and the cleanup that returns it.
struct PeerPermissions {
  spi::PermissionsHandle handle = {};
  Cleanup give_back = {};
};

/// The reports of a peer about its governance document; see GovernanceTransition.
struct GovernanceOfPeer {
  enum class State : std::uint8_t {
    changing,  ///< accepts the former protection and that of the document; sends by the former
    changed,   ///< accepts both; sends by that of the document
    in_force,  ///< accepts only that of the document
  };
  struct GovernanceReport {
    spi::AccessControl::GovernanceVersion version;
    State state = State::in_force;
    bool operator==(const GovernanceReport&) const = default;
  };
  std::optional<GovernanceReport> received = {};  ///< the latest
  std::optional<GovernanceReport> sent = {};      ///< the latest that we sent to the peer
  /// True if the peer has accepted the document that is in force here or comes into force. The peer
  /// is then told which protection keys are for, and its endpoints match with either.
  bool takes_part = false;
  /// The protection of messages whose keys were sent to the peer last; see MessageKeys.
  std::uint64_t message_keys = 0;
  /// This participant has keys for the next protection and has not announced it to the peer.
  bool lacks_keys = false;
  /// The peer announced that it lacks keys. Keys are sent again at once for a few such reports, and
  /// for more of them once a second.
  bool wants_keys = false;
  WorkBudget repetitions{3, std::chrono::seconds(5), {}};
  /// It was associated when another governance came into force here, which it did not have.
  bool was_associated_under_former = false;
  WorkBudget answers{3, std::chrono::seconds(5), {}};
};

/// The state that is shared with a peer that proved its identity. The members are destroyed in
/// reverse order: the keys first, then the permissions and the identity that the keys were created
/// for.
struct Association {
  /// The finished handshake; another one may run at the same time.
  std::unique_ptr<PeerHandshake> handshake = {};
  PeerPermissions permissions = {};
  std::string subject = {};  ///< of its certificate
  Cleanup place = {};        ///< returns its share of the places for its certificate
  struct Renewal {
    MonotonicTime next_offer{};  ///< earliest time for the next offer to the peer
    WorkBudget judgements{3, std::chrono::seconds(5), {}};  ///< of offers of the peer
  };
  Renewal renewal = {};  ///< see DocumentRenewal
  GovernanceOfPeer governance = {};
  MonotonicTime former_keys_end = kNever;  ///< of the keys that it has revised
  /// The peer has revised its keys. With its former keys, another participant may have sent a false
  /// end of one of its endpoints, and we dropped the keys of that endpoint. Missing keys are
  /// therefore requested.
  bool has_revised = false;
  EarlyTokens early = {};
  WaitingTokens waiting = {};
  std::unique_ptr<StatefulReader> volatile_reader = {};
  std::unique_ptr<StatefulWriter> volatile_writer = {};
  /// Makes the peer begin a new session if it keeps this one. Empty for a peer of another product.
  std::optional<spi::ResetToken> reset = {};
  Cleanup keys = {};  ///< removes them from the keyring
};

/// Each state owns what it needs; leaving a state releases it.
namespace peer {

/// Nothing is proven. If `is_admitted`, the peer takes part without authentication until it
/// succeeds and is permitted.
struct Unproven {
  std::unique_ptr<PeerHandshake> handshake;
  bool is_admitted = false;
};
/// The peer announced itself; no work was done for it.
struct Announced : Unproven {};
/// Its identity token is valid, and handshake messages are exchanged.
struct Authenticating : Unproven {};
/// The handshake took too long. It continues at a slow pace, because nothing proves that it cannot
/// succeed.
struct Waiting : Unproven {};
/// Authenticated and permitted; its participant key has not arrived yet.
struct AwaitingKeys {
  Association association;
  MonotonicTime since{};        ///< time of the handshake, or of the last request for another one
  bool exchanges_keys = false;  ///< it has shown that it has the shared secret
};
/// Its participant key has arrived, or none is needed.
struct Joined {
  Association association;
  MonotonicTime next_probe{};             ///< earliest time for the next probe
  MonotonicTime probe_deadline = kNever;  ///< of the running probe
};
/// A signed document forbids it to join, or its identity token is invalid. It gets another try with
/// a different announcement, and after a pause: documents of both sides are renewed while they run,
/// and nothing announces that. If `admits`, it takes part without authentication, also while it is
/// tried again.
struct Refused {
  bool admits = false;
};
/// It is no longer trusted. Its keys stay registered, but unused, until its endpoints are
/// unmatched.
struct Distrusted {
  std::optional<Association> former;
};

}  // namespace peer

/// The state of a peer. A transition that is not legal in the current state returns false and
/// changes nothing.
class PeerState {
 public:
  explicit PeerState(std::unique_ptr<PeerHandshake> handshake);

  // Transitions, in the order of the list in peer.cpp:
  bool on_handshake_begun();
  bool on_handshake_timeout();
  bool on_admission_timeout();
  /// Ends everything that an earlier handshake agreed on, because another one was finished.
  bool on_handshake_finished();
  /// `association` comes without its handshake, which is taken from the state that is left.
  bool on_permissions_validated(Association association, MonotonicTime now);
  bool on_key_exchange_message();
  /// Notes that another handshake was requested, because the keys did not arrive.
  bool on_keys_timeout(MonotonicTime now);
  bool on_participant_tokens();
  bool on_auth_request(MonotonicTime deadline, MonotonicTime next);
  bool on_probe_ended();
  /// If `admits`, the peer takes part without authentication from now on, or goes on to do so.
  bool on_refusal(bool admits);
  bool on_another_announcement(std::unique_ptr<PeerHandshake> handshake);
  bool on_trust_ended();

  template <class S>
  bool is() const {
    return std::holds_alternative<S>(state_);
  }
  /// Return nullptr if the peer is in another state.
  const peer::AwaitingKeys* awaiting_keys() const {
    return std::get_if<peer::AwaitingKeys>(&state_);
  }
  const peer::Joined* joined() const { return std::get_if<peer::Joined>(&state_); }
  const peer::Distrusted* distrusted() const { return std::get_if<peer::Distrusted>(&state_); }
  const peer::Unproven* unproven() const;
  /// True if it takes part without authentication.
  bool is_admitted() const;
  /// Returns nullptr in states that ignore handshake messages.
  PeerHandshake* handshake() const;
  /// Return nullptr if the peer is not authenticated, or no longer trusted.
  Association* association();
  const Association* association() const;

 private:
  template <class Event>
  bool apply(Event&& event);

  using State = std::variant<peer::Announced, peer::Authenticating, peer::Waiting,
                             peer::AwaitingKeys, peer::Joined, peer::Refused, peer::Distrusted>;
  State state_;
};

/// A participant that announced that it can authenticate.
struct Peer {
  ParticipantData data;
  bool answers_key_requests = false;  ///< it has proven that it does
  LocatorList metatraffic;
  PeerState state;
  WorkBudget low_rate_budget;  ///< handshake messages within the low rate
  SourceAddress source = {};   ///< of its latest announcement
  /// The source that announced each address of `metatraffic`.
  std::vector<SourceAddress> announced_by = {};
  bool was_announced = true;  ///< since a message was last repeated to it
  /// Octets of a message that waits until that many may be sent to the peer; 0: none waits.
  std::size_t deferred_octets = 0;
  bool may_send_deferred = false;  ///< the message that was held back may be sent now
  /// Octets that the expected answers to queries will allow sending to it.
  std::size_t expected_answer_octets = 0;
  bool has_spoken = false;             ///< has sent at least one handshake message
  bool was_counted_as_failed = false;  ///< something of it was refused, and that was counted
  int refusals = 0;  ///< how often it was refused since the local documents were renewed
  /// When it was refused, and when it gets another try.
  MonotonicTime refused_at = {}, next_attempt_at = kNever;

  const GuidPrefix& prefix() const { return data.guid.prefix; }
  std::string name() const { return data.guid.to_string(); }
};

}  // namespace ddssec::rtps
