// Renewed documents within a running session, as two tokens specific to ddssec: an offer with a
// signature for this session only, and the answer of the peer that has taken it.
#pragma once

#include "plugins/authentication/handshake.hpp"

namespace ddssec::authentication {

/// The documents that one side of a session presents again.
struct RenewalOffer {
  std::shared_ptr<const PresentedDocuments> documents;
  Sha256Digest digest;   ///< digest of the signed octets
  int times = 0;         ///< the number of times that it was sent
  MonotonicTime next{};  ///< earliest time to send it again
};

/// Returns the next token for the peer of `session`, and records it in `last`. Empty if the session
/// was made with the documents that `local` presents now, or if it is too early to offer them
/// again. Errors: those of pki::sign.
Result<std::optional<spi::OfferedRenewal>> next_offer(const EstablishedSession& session,
                                                      const OwnIdentity& local,
                                                      std::optional<RenewalOffer>& last,
                                                      const Clock& clock);

/// A peer's offer that was found to be genuine.
struct JudgedOffer {
  JudgedPeer peer;
  spi::Token answer;
};
/// The rules by which a peer's offer is judged.
struct OfferRules {
  const TrustStore& trust;
  OcspPolicy ocsp;
  WallTime now;
};
/// Judges the offer of the peer with that `guid`. Errors: those of TokenFields, those of
/// JudgedPeer::renewed, those of check_ocsp_status, signature_invalid.
Result<JudgedOffer> judge_offer(const EstablishedSession& session, const spi::Token& offer,
                                const Guid& guid, const OfferRules& rules);

/// Success if `answer` belongs to that offer. Errors: those of TokenFields, unexpected_message.
Status check_answer(const std::optional<RenewalOffer>& offer, const spi::Token& answer);

}  // namespace ddssec::authentication
