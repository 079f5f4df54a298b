// Verified documents. Each is verified and parsed once, whichever participant presents it.
#pragma once

#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "base/clock.hpp"
#include "base/hash.hpp"
#include "governance/decision.hpp"
#include "pki/smime.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::access_control {

/// The permissions CA of one participant.
class PermissionsCa {
 public:
  /// Loads the file named by `uri`. Errors: those of pki::load, of
  /// pki::Certificate::bundle_from_pem and of pki::DocumentVerifier::make.
  static Result<std::shared_ptr<const PermissionsCa>> load(const std::string& uri);

  /// Makes the object from certificates. Error: that of pki::DocumentVerifier::make.
  static Result<std::shared_ptr<const PermissionsCa>> of(std::vector<pki::Certificate> authorities);

  const pki::DocumentVerifier& verifier() const { return verifier_; }
  /// True if the certificate is one of those in the file.
  bool holds(const pki::Certificate& signer) const;
  /// Returns SHA-256 over the file's certificates.
  const Sha256Digest& digest() const { return digest_; }

  PermissionsCa(pki::DocumentVerifier verifier, const Sha256Digest& digest)
      : verifier_(std::move(verifier)), digest_(digest) {}

 private:
  pki::DocumentVerifier verifier_;
  Sha256Digest digest_;
};

/// A compiled grant.
using SharedGrant = std::shared_ptr<const governance::CompiledGrant>;

/// A permissions document whose signature was verified. Thread-safe.
class PermissionsDocument {
 public:
  PermissionsDocument(governance::Permissions permissions, const pki::SignedDocument& document);

  /// Returns the grant of the subject that is valid at `now`. It is compiled at most once for each
  /// domain and domain tag. Errors: those of governance::find_grant, and certificate_expired or
  /// certificate_not_yet_valid for the CA certificate that signed.
  Result<SharedGrant> grant_for(const pki::SubjectName& subject, std::string_view shown,
                                DomainId domain, const std::string& tag, WallTime now);
  const governance::Permissions& permissions() const { return *permissions_; }
  /// True if it has a grant for the subject, whatever its validity.
  bool has_grant_for(const pki::SubjectName& subject) const;
  /// Success while the signer's certificate is valid. Errors: certificate_expired,
  /// certificate_not_yet_valid.
  Status check_signer(WallTime now) const;
  WallTime signer_not_after() const { return signer_not_after_; }
  const pki::Certificate& signer() const { return signer_; }
  /// Returns the time at which the document was signed, as pki::SignedDocument does.
  std::optional<WallTime> signing_time() const { return signing_time_; }

  void set_partition_match(governance::PartitionMatch match) { partition_match_ = match; }

 private:
  /// The number of compiled grants that are stored; with more subjects, grants are compiled again.
  static constexpr std::size_t kMaxCompiled = 64;

  SharedGrant compiled(const governance::Grant& grant, DomainId domain, const std::string& tag);

  std::shared_ptr<const governance::Permissions> permissions_;
  WallTime signer_not_before_;
  WallTime signer_not_after_;
  pki::Certificate signer_;
  std::optional<WallTime> signing_time_;
  governance::PartitionMatch partition_match_ = governance::PartitionMatch::all;
  mutable std::mutex mutex_;
  std::map<std::tuple<const governance::Grant*, DomainId, std::string>, SharedGrant> compiled_;
};

/// Cache of verified permissions documents, by their octets and the CA. Bounded; the least recently
/// used entry is dropped first.
///
/// Only verified documents are stored, so peers can fill the cache only with documents that the CA
/// signed. The octets around the signed text can differ from one sender to the next. All forms of
/// one text that the CA signed at one time share one entry, which remembers few of them.
/// Thread-safe.
class DocumentCache {
 public:
  DocumentCache(governance::PartitionMatch partition_match, std::size_t max_documents,
                std::size_t max_octets)
      : partition_match_(partition_match), max_documents_(max_documents), max_octets_(max_octets) {}

  /// Verifies and parses `file`, or returns the cached document. Errors: those of
  /// pki::DocumentVerifier::verify and governance::read_permissions; for a cached document those of
  /// check_signer.
  Result<std::shared_ptr<PermissionsDocument>> permissions(const PermissionsCa& ca, BytesView file,
                                                           WallTime now);
  std::size_t size() const;

 private:
  static constexpr std::size_t kMaxForms = 4;
  struct Entry {
    Sha256Digest text;  ///< digest of the text with CA, signer and signing time
    std::size_t octets;
    std::shared_ptr<PermissionsDocument> document;
    std::vector<Sha256Digest> forms = {};  ///< digests of whole files with the CA; newest last
  };
  using Entries = std::list<Entry>;
  using Places = std::map<Sha256Digest, Entries::iterator>;
  std::shared_ptr<PermissionsDocument> find(Places& places, const Sha256Digest& key);
  void add_form(const Sha256Digest& text, const Sha256Digest& form);
  void insert(Entry entry);
  void drop_oldest();

  const governance::PartitionMatch partition_match_;
  const std::size_t max_documents_;
  const std::size_t max_octets_;
  mutable std::mutex mutex_;
  Entries entries_;  ///< most recently used first
  Places by_form_;
  Places by_text_;
  std::size_t octets_ = 0;
};

}  // namespace ddssec::access_control
