#include "cli/documents/signed_permissions.hpp"

#include <algorithm>
#include <utility>

#include "base/tool_code.hpp"
#include "governance/grant.hpp"
#include "governance/read.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::cli {

Result<SignedPermissions> own_permissions(const pki::SignedDocument& signed_document,
                                          const pki::Certificate& certificate, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(
      const auto document,
      governance::read_permissions(signed_document.content(), signed_document.first_line()));
  const auto subject = pki::SubjectName::of(certificate);
  const auto is_own = [&](const auto& grant) { return governance::is_for(grant, subject); };
  const auto is_valid_now = [&](const auto& grant) {
    return is_own(grant) && grant.validity.not_before <= now && now < grant.validity.not_after;
  };
  auto found = std::ranges::find_if(document.grants, is_valid_now);
  if (found == document.grants.end()) found = std::ranges::find_if(document.grants, is_own);
  if (found == document.grants.end())
    return fail(Code::no_grant_for_subject, {.found = certificate.subject()});
  // Refuses if another grant of the participant ends later: an extension would delay the rights
  // that it plans.
  const auto planned = std::ranges::find_if(document.grants, [&](const auto& grant) {
    return is_own(grant) && grant.validity.not_after > found->validity.not_after;
  });
  if (planned != document.grants.end())
    return fail(tool_code::document_superseded,
                {.field = "grants",
                 .expected = "one grant for " + certificate.subject(),
                 .found = "another that begins on " + to_string(planned->validity.not_before),
                 .note = "a document that plans other rights is not extended",
                 .hint = "sign a document for the time that follows: ddssec permissions sign"});
  return SignedPermissions{*found, found->validity.not_after <= now,
                           to_bytes(signed_document.content())};
}

governance::Permissions extended(const SignedPermissions& old, const pki::Certificate& certificate,
                                 WallTime until) {
  auto grant = old.grant;
  grant.subject_name = certificate.subject();
  grant.subject_is_expression = false;
  grant.validity.not_after = until;
  return {.grants = {std::move(grant)}};
}

}  // namespace ddssec::cli
