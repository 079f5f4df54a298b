// The OCSP response of a local identity, which handshakes show to peers. Another program fetches it
// (ddssec identity ocsp, ddssec agent) and writes its file, before or while the participant runs.
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

/// A response with the status "good" for our certificate.
struct OcspInForce {
  pki::Certificate certificate;
  Bytes octets;
  pki::GoodOcspStatus good;
};

/// Watches the file of the response. Not thread-safe.
class OwnOcspResponse {
 public:
  /// Makes the watch of the file that org.ddssec.auth.ocsp_response names, or else of ocsp.der
  /// beside the identity certificate. Error: invalid_property (it names no file; the poll
  /// interval).
  static Result<OwnOcspResponse> of(const spi::PropertyList& properties);

  /// The data by which a response is judged.
  struct Judge {
    const pki::Certificate& certificate;  ///< the certificate that handshakes present
    const TrustStore& trust;
    WallTime now;
  };
  /// Reads the file for the first time. A file that is missing or cannot be used is left to `poll`.
  /// Error: ocsp_revoked.
  Status read_first(const Judge& judge);
  /// Reads the file if it, or our certificate, may have changed. Returns true if another response
  /// came into force. `monotonic` is Clock::monotonic. Errors: ocsp_revoked, at every poll as long
  /// as it is so; ocsp_response_refused, with the fault, once as long as the file stays the same,
  /// and only at the second of two looks in a row; ocsp_response_ended, once. A missing file is no
  /// error, but a link to one is.
  Result<bool> poll(std::chrono::nanoseconds monotonic, const Judge& judge);
  /// Makes the next poll read the file, whatever the interval is.
  void force_poll() { watch_.force_poll(); }

  /// Returns the response in force; nullptr if there is none.
  const std::shared_ptr<const OcspInForce>& in_force() const { return in_force_; }
  /// Returns the path of the file; empty if none is named and the certificate is not in a file.
  const std::string& path() const { return path_; }
  /// For a person: the response in force for our certificate `own`, and the reason why the file is
  /// refused. Empty if there is neither.
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
  Sha256Digest content_{};  ///< digest of the file at the last reading
  std::optional<Error> revoked_;
  bool has_reported_end_ = false;
  RenewalRefusals refusals_;
};

}  // namespace ddssec::authentication
