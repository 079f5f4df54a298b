// OCSP responses (RFC 6960): what the CA, or a responder that it certified, says about one
// certificate. Nothing is fetched here.
#pragma once

#include <chrono>
#include <cstddef>

#include "base/bytes.hpp"
#include "base/clock.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"
#include "pki/chain.hpp"

namespace ddssec::pki {

/// The longest response that is looked into, in octets. With one certificate of an RSA-4096 key it
/// has less than 3 KiB. OpenSSL decodes the key of each certificate in it, which a stranger can
/// make it do: about 2.5 ms of CPU time at this length.
inline constexpr std::size_t kMaxOcspOctets = 4 * 1024;
/// Most answers that a response may hold, and most certificates that may come with it.
inline constexpr int kMaxOcspAnswers = 16;
inline constexpr int kMaxOcspCertificates = 4;
/// How far the clock of a responder may be off.
inline constexpr std::chrono::minutes kOcspClockSkew{5};
/// How long a response counts that does not say until when.
inline constexpr std::chrono::hours kOcspLifeWithoutEnd{24};

/// Proof that a responder of the certificate's CA calls it good. Only judge_ocsp creates one.
class OcspGood {
 public:
  WallTime this_update() const { return this_update_; }
  /// nextUpdate, or the end of the responder's certificate if that is earlier.
  WallTime until() const { return until_; }
  /// True if it counts at `now`; clocks may differ by kOcspClockSkew.
  bool holds_at(WallTime now) const {
    return this_update_ <= now + kOcspClockSkew && now <= until_ + kOcspClockSkew;
  }

 private:
  friend struct OcspJudge;
  OcspGood(WallTime this_update, WallTime until) : this_update_(this_update), until_(until) {}
  WallTime this_update_;
  WallTime until_;
};

/// What a response says of its own time; the signature is not checked.
struct OcspDates {
  WallTime this_update;  ///< the latest of its answers
  WallTime until;        ///< the earliest nextUpdate
};
/// Errors: ocsp_too_large, ocsp_malformed, ocsp_not_successful, out_of_memory.
Result<OcspDates> ocsp_dates(BytesView response);

/// Judges a response (DER) about `certificate`. It must be signed by the CA among the anchors that
/// issued the certificate, or by a responder that this CA issued a certificate with the extended
/// key usage OCSPSigning; `trust` judges that certificate like any other. A certificate that was
/// revoked stays so after the end of the response. SHA-1 may identify the certificate, as all
/// responders do it, but not sign.
///
/// Errors: ocsp_too_large, ocsp_malformed, ocsp_not_successful, ocsp_other_certificate,
/// ocsp_signer_wrong, ocsp_signature_invalid, ocsp_digest_too_weak, ocsp_revoked, ocsp_unknown,
/// ocsp_expired, ocsp_not_yet_valid, out_of_memory.
Result<OcspGood> judge_ocsp(BytesView response, const Certificate& certificate,
                            const ChainVerifier& trust, WallTime now);

}  // namespace ddssec::pki
