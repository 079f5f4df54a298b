// Puts a governance document that protects topics more into force while participants run, in two
// phases: first both protections are accepted, then the new one alone.
//
// A participant that has accepted the document reports that to its authenticated peers, in their
// protected channel. Peers that have the document too exchange keys for the new protection. A
// participant sends with the former protection until all peers with which it shares changed topics
// have its new keys, or until its time is over. After that it sends with the new one. It accepts
// the former protection until all peers have reported that they send with the new one, or until
// that time is over once more. Reports of peers only decide when that happens within this time: the
// document comes from the participant's own file, and the protection of sent messages never becomes
// less.
#pragma once

#include "rtps/security/admission.hpp"
#include "rtps/security/key_reviser.hpp"

namespace ddssec::rtps {

/// Leads one local participant from the former protection to that of a new document.
class GovernanceTransition {
 public:
  /// Added to the second phase, because messages take time and lost ones are sent again.
  static constexpr MonotonicTime kMargin = std::chrono::seconds(5);

  GovernanceTransition(SecurityCore& core, Admission& admission, CryptoTokenExchange& exchange,
                       KeyReviser& revision);

  /// Must be called once a second.
  void tick();
  /// Begins the second phase now and shortens it, because keys are to be revised.
  void finish();

 private:
  using Version = spi::AccessControl::GovernanceVersion;
  using State = GovernanceOfPeer::State;
  enum class Phase : std::uint8_t {
    none,
    accepting,  ///< both protections are accepted, the former one is sent
    draining,   ///< both are accepted, the new one is sent
  };

  void check();
  bool may_begin();
  void begin(const Version& next);
  void change();
  void end();
  /// Gives endpoints on changed topics their second protection. Returns false if one of them has
  /// none; an event reports that once. Nothing changes before this succeeds, so that no endpoint
  /// sends with less.
  bool add_protections();
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
  void judge_matches();
  template <class F>
  void each_joined(F&& f);

  SecurityCore& core_;
  Admission& admission_;
  CryptoTokenExchange& exchange_;
  KeyReviser& revision_;
  Phase phase_ = Phase::none;
  std::optional<Version> target_;             ///< the document of the change under way, or of the
                                              ///< last one
  std::optional<MonotonicTime> waits_since_;  ///< set while a document waits whose change has not
                                              ///< begun
  MonotonicTime deadline_ = kNever;
  bool has_failed_ = false;
  bool has_lost_any_ = false;  ///< an endpoint of a peer that matched lost its right
};

}  // namespace ddssec::rtps
