// An identity of our own: certificate, private key, certificate authorities, adjusted GUID.
#pragma once

#include <memory>
#include <mutex>
#include <optional>

#include "base/documents_in_use.hpp"
#include "base/ids.hpp"
#include "plugins/authentication/credentials.hpp"
#include "plugins/authentication/identity_files.hpp"
#include "plugins/spi/symmetric_cipher.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::authentication {

/// The documents that a handshake presents. A handshake takes them when it begins and keeps them to
/// its end. Renewed documents count for the next handshake, and the two never mix.
struct PresentedDocuments {
  pki::Certificate certificate;
  pki::PrivateKey key;
  /// c.perm; one NUL as long as there are no permissions, as Cyclone DDS sends and demands.
  Bytes permissions;
};

/// The identity of a local participant. Thread-safe; immutable except for the documents that it
/// presents and trusts.
class OwnIdentity {
 public:
  OwnIdentity(IdentityFiles files, const Guid& candidate);

  const Guid& guid() const { return guid_; }
  /// Returns the documents for handshakes that begin now.
  std::shared_ptr<const PresentedDocuments> presented() const;
  pki::Certificate certificate() const { return presented()->certificate; }
  /// Returns the certificates that are trusted now.
  std::shared_ptr<const TrustStore> peer_trust() const;
  spi::Token identity_token(spi::CipherMask ciphers) const;

  /// Judges our own certificate again. Errors of ChainVerifier::verify.
  Result<pki::ValidChain> verify(WallTime now) const { return verify(certificate(), now); }
  /// Returns the same for a certificate that a handshake presents.
  Result<pki::ValidChain> verify(const pki::Certificate& own, WallTime now) const;

  /// Returns the warnings that are due now, each once: identity_ends_soon, crl_ends_soon.
  std::vector<Error> ends_soon(WallTime now);

  /// Puts newer revocation lists into force if their file contains any; from then on they are used
  /// for every check. Returns true if it did. Errors: those of RevocationLists::poll and
  /// check_renewal, trusted_ca_dir_with_crl. Those of ChainVerifier::verify if our own certificate
  /// would no longer be accepted, unless it is revoked.
  Result<bool> renew_revocation_lists(TrustStores& stores, const Clock& clock);
  /// Returns the paths of the files of revocation lists, if there are any.
  std::string revocation_list_path() const;
  /// Returns the number and the date of each revocation list, for a person.
  std::string revocation_lists() const;

  /// Takes a renewed certificate, with its key, if their files contain one; from then on handshakes
  /// present it. Returns true if it did. Errors: those of IdentityWatch::poll. The comment at
  /// check_renewed has the reasons to refuse a certificate.
  Result<bool> renew_identity(const Clock& clock);

  /// Takes another OCSP response about our certificate, if its file contains one; from then on
  /// handshakes show it. Returns true if it did. Errors: those of OwnOcspResponse::poll.
  Result<bool> renew_ocsp_response(const Clock& clock);
  /// Returns the response by which our `certificate` is good at `now`; nullptr if there is none.
  std::shared_ptr<const OcspInForce> ocsp_response_for(const pki::Certificate& certificate,
                                                       WallTime now) const;
  /// Returns the rule by which peers' responses are judged.
  OcspPolicy ocsp_policy() const { return ocsp_policy_; }
  /// Returns the path of the file of our response; empty if there is none.
  const std::string& ocsp_response_path() const { return ocsp_response_.path(); }
  /// Returns the reason if our own response says that our certificate is revoked.
  std::optional<Error> ocsp_revoked() const;

  /// Returns the path of the certificate; empty if it is not in a file.
  const std::string& identity_path() const { return watch_.path(); }

  /// Returns the renewal list, with renewed certificates of peers.
  ListedRenewals& listed() const { return *listed_; }
  /// Returns the certificate on the renewal list that follows `seen`, one of this participant: of
  /// the same key, valid at `now`, and accepted by its own CAs.
  std::optional<pki::ValidChain> listed_after(const pki::Certificate& seen, WallTime now) const;

  struct AuthorityRenewal {
    bool authorities = false;  ///< true if other identity CAs came into force
    bool identity = false;     ///< true if a certificate of one of them did, too
  };
  /// Takes other identity CAs if their file contains any; from then on they are used for every
  /// check. They must accept our own certificate: the one in force, or else the one that is now in
  /// its file. The latter then comes into force, together with the revocation lists in their file.
  /// Errors: those of AuthorityWatch::poll.
  Result<AuthorityRenewal> renew_authorities(TrustStores& stores, const Clock& clock);
  /// Takes other CAs of the trusted_ca_dir, if there is one; from then on peers are judged by them.
  /// They must include each of our own identity CAs. Returns true if it did. Errors: those of
  /// TrustedFolder::poll.
  Result<bool> renew_trusted_folder(TrustStores& stores, const Clock& clock);
  /// Returns the path of the CAs by which peers are judged: the trusted_ca_dir if there is one,
  /// else authorities_path().
  const std::string& peer_authorities_path() const {
    return trusted_folder_ ? trusted_folder_->path() : authorities_path();
  }
  /// Returns the subjects of these CAs, for a person.
  std::string peer_authorities() const { return pki::describe(peer_trust()->anchors()); }

  /// Returns the path of the identity CAs; the property's name if they are not in a file.
  const std::string& authorities_path() const { return authorities_.name(); }
  /// Returns the subjects of the identity CAs, for a person.
  std::string authorities() const { return pki::describe(own_trust()->anchors()); }

  /// Returns the certificate, CAs and revocation lists in force, and the refused ones.
  std::vector<DocumentState> documents() const;

  /// Makes the next renew_... calls read the files, whatever the poll interval is.
  void force_poll();

  /// Documents that came into force and by which no peer was judged yet.
  struct UnappliedRenewal {
    std::uint64_t renewal;  ///< the number of times that lists or CAs came into force
    bool authorities;       ///< true if CAs are among them
  };
  std::optional<UnappliedRenewal> unapplied_renewal() const;
  void note_applied(std::uint64_t renewal);

  /// Sets the permissions from a PermissionsCredentialToken. Errors: permissions_credential_wrong,
  /// token_field_length.
  Status set_permissions(const spi::Token& credential);

  /// Returns `own.hash()`, which is remembered: it is the same for every peer as long as the
  /// documents, the participant data and the key agreement are. `own` must be made from
  /// `presented`.
  Sha256Digest hash_of(const std::shared_ptr<const PresentedDocuments>& presented,
                       const Credentials& own) const;

 private:
  struct KnownHash {
    Bytes variable;  ///< c.pdata and c.kagree_algo
    std::shared_ptr<const PresentedDocuments> presented;
    Sha256Digest digest;
  };

  std::shared_ptr<const TrustStore> own_trust() const;
  Status adopt_lists(const std::vector<pki::Crl>& lists, TrustStores& stores, WallTime now);
  Status check_renewed(const IdentityWatch::FoundIdentity& found, const TrustStore& trust,
                       WallTime now) const;
  Result<bool> adopt_authorities(const std::vector<pki::Certificate>& next, TrustStores& stores,
                                 WallTime now);
  Status adopt_with_identity(const std::vector<pki::Certificate>& next,
                             const IdentityWatch::FoundIdentity& identity, TrustStores& stores,
                             WallTime now);
  void trust(std::shared_ptr<const TrustStore> store);
  DocumentState state_of_authorities() const;

  const Guid guid_;
  /// Guards watch, lists and warnings; locked before mutex_. Files are read under it, so no
  /// handshake may wait for it.
  mutable std::mutex renewal_mutex_;
  IdentityWatch watch_;
  pki::AuthorityWatch authorities_;
  std::optional<TrustedFolder> trusted_folder_;  ///< there is one from the start, or never
  RevocationLists revocation_lists_;
  const OcspPolicy ocsp_policy_;
  OwnOcspResponse ocsp_response_;
  const std::shared_ptr<ListedRenewals> listed_;
  spi::EndWarning certificate_warning_;
  spi::EndWarning list_warning_;
  mutable std::mutex mutex_;
  std::shared_ptr<const TrustStore> own_trust_;
  std::shared_ptr<const TrustStore> peer_trust_;
  std::uint64_t renewals_ = 0;
  std::uint64_t authorities_renewal_ = 0;  ///< the last of `renewals_` in which other CAs came
  std::uint64_t applied_renewals_ = 0;
  std::shared_ptr<const PresentedDocuments> presented_;
  std::shared_ptr<const OcspInForce> ocsp_in_force_;
  std::optional<Error> ocsp_revoked_;
  mutable std::optional<KnownHash> known_hash_;
};

}  // namespace ddssec::authentication
