// Renewed documents within a running session, as two tokens of our own: an offer with a signature
// for this session alone, and the answer of the peer that has taken it.
#pragma once

#include "plugins/authentication/handshake.hpp"

namespace ddssec::authentication {

/// What one side of a session presents anew.
struct RenewalOffer {
  std::shared_ptr<const Presented> documents;
  Sha256Digest digest;  ///< of what its signature covers
  int times = 0;        ///< how often it was sent
};

/// The next token for the peer of `session`, which is put down in `last`. Empty if the session was
/// made with what `local` presents now, or if that was offered as often as is sensible. Errors of
/// pki::sign.
Result<std::optional<spi::Token>> next_offer(const Established& session, const LocalIdentity& local,
                                             std::optional<RenewalOffer>& last, WallTime now);

/// An offer of the peer that was found to be genuine.
struct JudgedOffer {
  JudgedPeer peer;
  spi::Token answer;
};
/// How a peer's offer is judged.
struct OfferRules {
  const TrustStore& trust;
  OcspPolicy ocsp;
  WallTime now;
};
/// `guid`: the peer's. Errors: those of TokenFields, those of JudgedPeer::renewed, those of
/// check_ocsp_status, signature_invalid.
Result<JudgedOffer> judge_offer(const Established& session, const spi::Token& offer,
                                const Guid& guid, const OfferRules& rules);

/// Success if `answer` is to that offer. Errors: those of TokenFields, unexpected_message.
Status check_answer(const std::optional<RenewalOffer>& offer, const spi::Token& answer);

}  // namespace ddssec::authentication
