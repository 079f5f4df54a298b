#include "cli/documents/signed_permissions.hpp"

#include <algorithm>
#include <utility>

#include "base/tool_code.hpp"
#include "governance/grant.hpp"
#include "governance/read.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::cli {

Result<SignedPermissions> permissions_of(const pki::SignedDocument& signed_document,
                                         const pki::Certificate& certificate, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(
      auto document,
      governance::read_permissions(signed_document.content(), signed_document.first_line()));
  const auto subject = pki::SubjectName::of(certificate);
  std::erase_if(document.grants,
                [&](const auto& grant) { return !governance::is_for(grant, subject); });
  const auto& own = document.grants;
  if (own.empty()) return fail(Code::no_grant_for_subject, {.found = certificate.subject()});
  const auto found = std::ranges::find_if(own, [&](const auto& grant) {
    return grant.validity.not_before <= now && now < grant.validity.not_after;
  });
  const auto& grant = found == own.end() ? own.front() : *found;
  const auto end = [](const auto& one) { return one.validity.not_after; };
  return SignedPermissions{.grant = grant,
                           .has_ended = grant.validity.not_after <= now,
                           .last_end = end(*std::ranges::max_element(own, {}, end)),
                           .text = to_bytes(signed_document.content())};
}

Result<SignedPermissions> own_permissions(const pki::SignedDocument& document,
                                          const pki::Certificate& certificate, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(auto out, permissions_of(document, certificate, now));
  if (out.last_end <= out.grant.validity.not_after) return out;
  return fail(tool_code::document_superseded,
              {.field = "grants",
               .expected = "one grant for " + certificate.subject(),
               .found = "another that ends on " + to_string(out.last_end),
               .note = "a document that plans other rights is not extended",
               .hint = "sign a document for the time that follows: ddssec permissions sign"});
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
