// The permissions in a participant's renewal list: later ones of peers.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "plugins/access_control/documents.hpp"

namespace ddssec::access_control {

/// Documents whose signatures were verified. Thread-safe; only what it remembers changes.
class ListedPermissions {
 public:
  /// A signed file and what it holds.
  struct Entry {
    Sha256Digest file;  ///< as session_facts.hpp counts it
    std::shared_ptr<PermissionsDocument> document;
  };
  explicit ListedPermissions(const std::vector<Entry>& entries);

  /// Whose permissions are looked for.
  struct Question {
    const pki::SubjectName& subject;
    const std::string& shown;
    DomainId domain;
    const std::string& tag;
    const PermissionsCa& ca;
    WallTime now;
  };
  struct Found {
    std::shared_ptr<PermissionsDocument> document;
    Grant grant;
  };
  /// Of the documents of the CA with a grant of the subject's name (not of an expression) that has
  /// begun and says something of the domain and tag, the one whose grant begins last, of these the
  /// one that was signed last, and of these the one that ends last. It may have ended: it still
  /// says that those before it do not count.
  std::optional<Found> latest(const Question& question) const;

  /// True if that file is on the list.
  bool holds(const Sha256Digest& file) const { return files_.contains(file); }

 private:
  using Documents = std::vector<std::shared_ptr<PermissionsDocument>>;
  Documents documents_of(const Question& question) const;
  static bool says_something(const governance::Grant& grant, const Question& question);

  Documents documents_;
  std::set<Sha256Digest> files_;
  mutable std::mutex mutex_;
  mutable std::map<std::string, Documents> of_subject_;  ///< those asked for so far
};

/// True if `found` may take the place of `former`: its grant begins later; or at the same time, and
/// it was signed later; or both are the same, and it ends later.
bool is_later(const ListedPermissions::Found& found, const ListedPermissions::Found& former);

/// The same without the end; false if they are of one document.
bool supersedes(const ListedPermissions::Found& found, const ListedPermissions::Found& former);

/// True if it is valid, and so is its signer's certificate.
bool is_valid(const ListedPermissions::Found& one, WallTime now);

/// True if both allow and deny the same in the domain with the tag, whatever their validity.
bool give_the_same(const governance::Grant& a, const governance::Grant& b, DomainId domain,
                   std::string_view tag);

/// The digest of a signed file, as authentication has it (session_facts.hpp).
Sha256Digest digest_of_file(std::string_view text);

}  // namespace ddssec::access_control
