// One remote participant that may authenticate, as a state machine. The legal transitions are
// listed at the top of peer.cpp.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "rtps/budget/source_address.hpp"
#include "rtps/budget/work_budget.hpp"
#include "rtps/discovery/participant_data.hpp"
#include "rtps/security/association.hpp"

namespace ddssec::rtps {

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
