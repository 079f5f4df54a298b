// Puts a governance document that protects topics or the domain more into force while participants
// run, in two phases: first both protections are accepted, then the new one alone.
//
// A participant that has taken the document says so to its authenticated peers, in their protected
// channel. Those that have it, too, exchange keys for the new protection. A participant goes on to
// send with the former one until all peers that it shares changed topics with have its new keys
// (all peers, if the document changes the domain), or until its time is over; then it sends with
// the new one. From then on it accepts the former protection only from peers that have not said
// that they send with the new one, until all have said so, or until that time is over once more.
// What peers say decides when that happens within this time, and nothing else: the document comes
// from the own file, and the protection of what is sent never becomes less. Peers without the
// document part when a change of the domain is over.
#pragma once

#include "rtps/security/admission.hpp"
#include "rtps/security/key_reviser.hpp"

namespace ddssec::rtps {

/// Leads one local participant from the former protection to that of a new document.
class GovernanceTransition {
 public:
  /// Added to the second phase, because messages take time and lost ones are sent again.
  static constexpr MonotonicTime kMargin = std::chrono::seconds(5);

  GovernanceTransition(GovernanceChangeState& state, SecurityCore& core, Admission& admission,
                       CryptoTokenExchange& exchange, KeyReviser& key_reviser);

  /// Call it once a second.
  void tick();
  /// Call it while keys are revised, or are to be. A second phase does not last long then.
  void note_revision();

 private:
  using Version = GovernanceChangeState::Version;
  using Phase = GovernanceChangeState::Phase;
  using State = GovernanceOfPeer::State;

  void poll_document();
  bool may_begin();
  void begin(const Version& next);
  void change();
  void end();
  /// Gives endpoints on changed topics their second protection. Returns false if one of them has
  /// none; an event reports that once. Nothing changes before this succeeds, so that no endpoint
  /// sends with less.
  bool add_protections();
  Status add_second_protections();
  void want_keys();
  /// Sends keys to the peer that it wants again, if any.
  void send_again(Peer& peer);
  bool complete_pairs();
  /// True if the peer has all that it needs for the new protection, or shares no changed topic.
  bool is_ready(const Peer& peer) const;
  bool has_changed(const Peer& peer) const;
  void refresh(Peer& peer) const;
  /// Returns this participant's report about itself.
  GovernanceOfPeer::GovernanceReport own() const;
  void send_report(Peer& peer, bool wants_answer);
  void send_to_all();
  void on_message(Peer& peer, const spi::Token& report);
  void report_behind();
  void rematch();
  void note_all_former();
  /// Those that were there when the domain changed, and have not taken the document since.
  std::vector<GuidPrefix> peers_of_former();
  template <class F>
  void each_joined(F&& f);

  GovernanceChangeState& state_;
  SecurityCore& core_;
  Admission& admission_;
  CryptoTokenExchange& exchange_;
  KeyReviser& key_reviser_;
  /// Set while a document waits whose change has not begun.
  std::optional<MonotonicTime> waits_since_;
  MonotonicTime deadline_ = kNever;
  bool has_protections_ = false;  ///< there are keys for all second protections
  bool has_failed_ = false;
  bool has_lost_any_ = false;  ///< an endpoint of a peer that matched lost its right
};

}  // namespace ddssec::rtps
