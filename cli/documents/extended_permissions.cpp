#include "cli/documents/extended_permissions.hpp"

#include <algorithm>
#include <utility>

#include "governance/grant.hpp"
#include "governance/read.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::cli {

Result<OldPermissions> own_permissions(const pki::SignedDocument& signed_document,
                                       const pki::Certificate& certificate, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(
      const auto document,
      governance::read_permissions(signed_document.content(), signed_document.first_line()));
  const auto subject = pki::SubjectName::of(certificate);
  const auto found = std::ranges::find_if(
      document.grants, [&](const auto& grant) { return governance::is_for(grant, subject); });
  if (found == document.grants.end())
    return fail(Code::no_grant_for_subject, {.found = certificate.subject()});
  return OldPermissions{*found, found->validity.not_after <= now,
                        to_bytes(signed_document.content())};
}

governance::Permissions extended(const OldPermissions& old, const pki::Certificate& certificate,
                                 WallTime until) {
  auto grant = old.grant;
  grant.subject_name = certificate.subject();
  grant.subject_is_expression = false;
  grant.validity.not_after = until;
  return {.grants = {std::move(grant)}};
}

}  // namespace ddssec::cli
