// OCSP responses (RFC 6960): statements of the CA, or of a responder that it certified, about one
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

/// The longest response that is decoded, in octets. A response with one certificate of an RSA-4096
/// key has less than 3 KiB. OpenSSL decodes the key of each certificate in it, and a stranger can
/// cause that: about 2.5 ms of CPU time at this length.
inline constexpr std::size_t kMaxOcspOctets = 4 * 1024;
/// The largest number of answers in a response, and of certificates that may come with it.
inline constexpr int kMaxOcspAnswers = 16;
inline constexpr int kMaxOcspCertificates = 4;
/// The largest tolerated difference from the clock of a responder.
inline constexpr std::chrono::minutes kOcspClockSkew{5};
/// How long a response without nextUpdate is valid.
inline constexpr std::chrono::hours kOcspLifeWithoutEnd{24};

/// Proof that a responder of the certificate's CA reports it as good. Only judge_ocsp creates one.
class GoodOcspStatus {
 public:
  WallTime this_update() const { return this_update_; }
  /// Returns nextUpdate, or the end of the responder's certificate if that is earlier.
  WallTime until() const { return until_; }
  /// True if the proof is valid at `now`; clocks may differ by kOcspClockSkew.
  bool holds_at(WallTime now) const {
    return this_update_ <= now + kOcspClockSkew && now <= until_ + kOcspClockSkew;
  }

 private:
  friend struct OcspJudge;
  GoodOcspStatus(WallTime this_update, WallTime until) : this_update_(this_update), until_(until) {}
  WallTime this_update_;
  WallTime until_;
};

/// The dates that a response states. Its signature is not checked.
struct OcspDates {
  WallTime this_update;  ///< the latest thisUpdate of its answers
  WallTime until;        ///< the earliest nextUpdate
};
/// Reads the dates of a response. Errors: ocsp_too_large, ocsp_malformed, ocsp_not_successful,
/// out_of_memory.
Result<OcspDates> ocsp_dates(BytesView response);

/// Judges a response (DER) about `certificate`. It must be signed by the CA among the anchors that
/// issued the certificate, or by a responder that this CA issued a certificate with the extended
/// key usage OCSPSigning; `trust` judges that certificate like any other. A revocation still counts
/// after the end of the response. SHA-1 may identify the certificate, because all responders use it
/// for that, but SHA-1 may not sign.
///
/// Errors: ocsp_too_large, ocsp_malformed, ocsp_not_successful, ocsp_other_certificate,
/// ocsp_signer_wrong, ocsp_signature_invalid, ocsp_digest_too_weak, ocsp_revoked, ocsp_unknown,
/// ocsp_expired, ocsp_not_yet_valid, out_of_memory.
Result<GoodOcspStatus> judge_ocsp(BytesView response, const Certificate& certificate,
                                  const ChainVerifier& trust, WallTime now);

}  // namespace ddssec::pki
