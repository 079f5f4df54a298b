// Shows the peers documents that were renewed during a session, and accepts theirs, so that the
// session goes on. DDS-Security defines no such messages: participants of other vendors ignore
// them, and their sessions end with the documents of the handshake.
#pragma once

#include "rtps/security/key_reviser.hpp"

namespace ddssec::rtps {

/// Offers renewed documents of one local participant to its peers, and judges what they offer.
class DocumentRenewal {
 public:
  DocumentRenewal(SecurityCore& core, CryptoTokenExchange& exchange, KeyReviser& key_reviser);

  /// Shows the peers the documents that were renewed. Call it once a second.
  void offer_to_all();
  /// Judges all endpoints again, because the local permissions were renewed.
  void on_own_rights_changed();
  /// Returns the peers whose renewed permissions do not let them take part any more, since the last
  /// call.
  std::vector<GuidPrefix> take_excluded() { return std::exchange(excluded_, {}); }

 private:
  void offer_to(Peer& peer);
  void report_too_large(const Peer& peer, const spi::Token& offer);
  void report_not_accepted(const Peer& peer);
  void on_offer(Peer& peer, const spi::Token& offer);
  void rematch_endpoints_of(const GuidPrefix& prefix);
  void on_accepted(Peer& peer, const spi::Token& answer);

  SecurityCore& core_;
  CryptoTokenExchange& exchange_;
  KeyReviser& key_reviser_;
  std::vector<GuidPrefix> excluded_;
};

}  // namespace ddssec::rtps
