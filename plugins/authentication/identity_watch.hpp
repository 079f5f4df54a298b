// The files of a local identity, whose certificate and key may be renewed while it runs.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "base/file_watch.hpp"
#include "base/renewal_refusals.hpp"
#include "pki/private_key.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::authentication {

/// The passphrase of the key; nullptr if the key has none.
using OwnPassphrase = std::shared_ptr<const pki::Passphrase>;
/// Reads the passphrase of the key. Error: invalid_property.
Result<OwnPassphrase> own_passphrase(const spi::PropertyList& properties);
/// Reads the certificate (and the next function the key) that the properties name. Errors name the
/// property: those of pki, invalid_property.
Result<pki::Certificate> load_identity_certificate(const spi::PropertyList& properties);
Result<pki::PrivateKey> load_identity_key(const spi::PropertyList& properties);

/// Watches the certificate only if a `file:` URI names it. A key that is not in a file (but in a
/// token, or in the property itself) stays, and a renewed certificate must be for it. Not
/// thread-safe.
class IdentityWatch {
 public:
  /// Call it before the files are read for the first time. Error: invalid_property (the poll
  /// interval).
  static Result<IdentityWatch> of(const spi::PropertyList& properties);

  struct FoundIdentity {
    pki::Certificate certificate;
    pki::PrivateKey key;
  };
  /// Judges a certificate and key that would replace those in force.
  using Accept = std::function<Status(const FoundIdentity&)>;
  /// Reads the files if one of them may have changed. The octets that were read are those that are
  /// judged and returned. Empty if the files contain the certificate in force. The files may be
  /// replaced one after the other. A mismatch is therefore an error only if it is found at two
  /// looks in a row. `now` is Clock::monotonic. Error, once as long as the files stay the same:
  /// identity_renewal_refused, about the file, with the fault.
  Result<std::optional<FoundIdentity>> poll(std::chrono::nanoseconds now,
                                            const FoundIdentity& in_force, const Accept& accept);

  /// Makes the next poll read the files, whatever the interval is.
  void force_poll() {
    certificate_.force_poll();
    key_.force_poll();
  }

  /// Reads the files as they are now, whether they have changed or not. Errors: those of pki.
  Result<FoundIdentity> read(const FoundIdentity& in_force) const;

  /// Returns the last error of poll(), as long as the files have not been good since.
  const std::optional<Error>& refused() const { return refusals_.refused(); }
  /// Returns the state of the files.
  FileState state() const { return refusals_.state(); }

  /// Returns the path of the certificate; empty if it is not in a file.
  const std::string& path() const { return path_; }

 private:
  IdentityWatch(std::string path, std::string key_path, std::chrono::seconds interval);
  Result<std::optional<FoundIdentity>> judge(const FoundIdentity& in_force, const Accept& accept,
                                             Sha256Digest& content) const;
  Result<pki::PrivateKey> key(const FoundIdentity& in_force) const;
  const std::string& path_of(const Error& error) const;

  std::string path_;
  std::string key_path_;  ///< empty if the key is not in a file
  OwnPassphrase passphrase_;
  FileWatch certificate_;
  FileWatch key_;
  RenewalRefusals refusals_;
};

}  // namespace ddssec::authentication
