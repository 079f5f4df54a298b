// Extends a participant's permissions to a later end, as a renewal signs them.
#pragma once

#include "base/bytes.hpp"
#include "base/clock.hpp"
#include "base/result.hpp"
#include "governance/model.hpp"
#include "pki/certificate.hpp"
#include "pki/smime.hpp"

namespace ddssec::cli {

/// A participant's permissions that the CA signed.
struct SignedPermissions {
  governance::Grant grant;  ///< the participant's own
  bool has_ended;
  Bytes text;  ///< the text of the whole document
};

/// Returns the grant for the certificate's subject. Errors: no_grant_for_subject, those of
/// governance::read_permissions.
Result<SignedPermissions> own_permissions(const pki::SignedDocument& document,
                                          const pki::Certificate& certificate, WallTime now);

/// Returns a document with this grant until `until`, and without any other grant that its name may
/// match.
governance::Permissions extended(const SignedPermissions& old, const pki::Certificate& certificate,
                                 WallTime until);

}  // namespace ddssec::cli
