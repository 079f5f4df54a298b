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
  governance::Grant grant;  ///< the participant's own: the one that is valid now, or else the first
  bool has_ended;
  WallTime last_end;  ///< the end of the participant's last grant, which may be planned for later
  Bytes text;         ///< the text of the whole document
};

/// Returns the grant for the certificate's subject. Errors: no_grant_for_subject, those of
/// governance::read_permissions.
Result<SignedPermissions> permissions_of(const pki::SignedDocument& document,
                                         const pki::Certificate& certificate, WallTime now);

/// As permissions_of, for a document that is to be extended. Errors: also document_superseded, if
/// another grant of the participant ends later: an extension would delay the rights that it plans.
Result<SignedPermissions> own_permissions(const pki::SignedDocument& document,
                                          const pki::Certificate& certificate, WallTime now);

/// Returns a document with this grant until `until`, and without any other grant that its name may
/// match.
governance::Permissions extended(const SignedPermissions& old, const pki::Certificate& certificate,
                                 WallTime until);

}  // namespace ddssec::cli
