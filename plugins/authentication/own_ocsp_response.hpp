// The OCSP response of a local identity, which handshakes show to peers. Something else fetches it
// (ddssec identity ocsp, ddssec agent) and puts its file into place, before or while the
// participant runs.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "base/documents_in_use.hpp"
#include "base/file_watch.hpp"
#include "base/renewal_refusals.hpp"
#include "plugins/authentication/trust_store.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::authentication {

/// A response that says "good" of our certificate.
struct OcspInForce {
  pki::Certificate certificate;
  Bytes octets;
  pki::OcspGood good;
};

/// Not thread-safe.
class OwnOcspResponse {
 public:
  /// The file that org.ddssec.auth.ocsp_response names, or ocsp.der beside the identity
  /// certificate. Error: invalid_property (it names no file; the poll interval).
  static Result<OwnOcspResponse> of(const spi::PropertyList& properties);

  /// What a response is judged by.
  struct Judge {
    const pki::Certificate& certificate;  ///< that handshakes present
    const TrustStore& trust;
    WallTime now;
  };
  /// Reads the file for the first time; one that is missing or cannot be used is left to `poll`.
  /// Error: ocsp_revoked.
  Status read_first(const Judge& judge);
  /// Reads the file if it, or our certificate, may have changed. True: another response is in
  /// force. `monotonic`: Clock::monotonic. Errors: ocsp_revoked, at every poll as long as it is so;
  /// once, as long as the file stays the same, and only of two looks in a row:
  /// ocsp_response_refused, with what is wrong; once: ocsp_response_ended.
  Result<bool> poll(std::chrono::nanoseconds monotonic, const Judge& judge);
  /// The next poll reads the file, whatever the interval is.
  void force_poll() { watch_.force_poll(); }

  /// Null: there is none.
  const std::shared_ptr<const OcspInForce>& in_force() const { return in_force_; }
  /// The path of the file; empty if none is named, and the certificate is no file.
  const std::string& path() const { return path_; }
  /// For a person: the response in force for our certificate `own`, and why the file is refused.
  /// Nothing if there is neither.
  std::optional<DocumentState> state(const pki::Certificate& own) const;

 private:
  OwnOcspResponse(const std::string& path, std::chrono::seconds interval);
  Result<bool> read(const Judge& judge);
  Result<bool> refuse(const Error& why);
  Status note_end(const Judge& judge);

  std::string path_;
  FileWatch watch_;
  std::shared_ptr<const OcspInForce> in_force_;
  std::optional<pki::Certificate> judged_for_;
  Sha256Digest content_{};  ///< of the file at the last reading
  std::optional<Error> revoked_;
  bool has_reported_end_ = false;
  RenewalRefusals refusals_;
};

}  // namespace ddssec::authentication
