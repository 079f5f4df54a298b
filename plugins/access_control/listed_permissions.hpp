// The permissions in a participant's renewal list: they extend those of peers.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/access_control/documents.hpp"

namespace ddssec::access_control {

/// A grant and its document.
struct GrantOfDocument {
  std::shared_ptr<PermissionsDocument> document;
  SharedGrant grant;
};

/// Returns the end of the grant, or of the signer's certificate if that ends before.
WallTime end_of(const GrantOfDocument& one);

/// The rights that other permissions must give to extend those that a subject presented.
enum class ExtendingRights : std::uint8_t { at_least_the_same, the_same };

/// Documents whose signatures were verified. Thread-safe; only the cache changes.
class ListedPermissions {
 public:
  using Documents = std::vector<std::shared_ptr<PermissionsDocument>>;
  explicit ListedPermissions(Documents documents) : documents_(std::move(documents)) {}

  /// Permissions that a subject presented.
  struct PresentedPermissions {
    const pki::SubjectName& subject;
    const std::string& shown;
    DomainId domain;
    const std::string& tag;
    const PermissionsDocument& document;
    const governance::Grant& grant;
    ExtendingRights by = ExtendingRights::at_least_the_same;
  };
  /// Returns the document that extends the presented permissions. It is signed by the CA, has a
  /// grant for the subject's name (not for an expression) that is valid now, and gives the same in
  /// the domain with the tag; or it gives more and was not signed earlier. If there are several
  /// such documents, it is the one that ends last. Documents that give less have no effect.
  std::optional<GrantOfDocument> extension_of(const PresentedPermissions& presented,
                                              const PermissionsCa& ca, WallTime now) const;

 private:
  Documents documents_for(const PresentedPermissions& presented) const;

  const Documents documents_;
  mutable std::mutex mutex_;
  /// Documents of the subjects that were looked up.
  mutable std::map<std::string, Documents> of_subject_;
};

/// False if `next` was signed before `former`, or if only `former` has a signing time.
bool is_signed_later(const PermissionsDocument& next, const PermissionsDocument& former);

/// Compares as governance::gives_at_least does, in the domain with the tag.
bool gives_at_least(const governance::Grant& next, const governance::Grant& former, DomainId domain,
                    std::string_view tag);

/// True if both allow and deny the same in the domain with the tag, whatever their validity.
bool give_same_rights(const governance::Grant& a, const governance::Grant& b, DomainId domain,
                      std::string_view tag);

}  // namespace ddssec::access_control
