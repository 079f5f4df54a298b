// The files that the properties of a participant name for authentication.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pki/authority_watch.hpp"
#include "pki/private_key.hpp"
#include "plugins/authentication/identity_watch.hpp"
#include "plugins/authentication/listed_renewals.hpp"
#include "plugins/authentication/ocsp_status.hpp"
#include "plugins/authentication/own_ocsp_response.hpp"
#include "plugins/authentication/revocation_lists.hpp"
#include "plugins/authentication/trust_store.hpp"
#include "plugins/authentication/trusted_folder.hpp"
#include "plugins/spi/end_warning.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::authentication {

/// The documents that the properties of a participant name, loaded and found to fit together.
struct IdentityFiles {
  pki::Certificate certificate;
  pki::PrivateKey key;
  IdentityWatch watch;              ///< watches the files of certificate and key
  pki::AuthorityWatch authorities;  ///< watches the file of identity_ca
  RevocationLists revocation_lists;
  std::shared_ptr<const TrustStore> own_trust;   ///< identity_ca, with the revocation lists
  std::shared_ptr<const TrustStore> peer_trust;  ///< the same, or the trusted_ca_dir
  std::optional<TrustedFolder> trusted_folder;
  spi::WarningDays warn_before_end;
  OcspPolicy ocsp_policy;
  OwnOcspResponse ocsp_response;
  std::shared_ptr<ListedRenewals> listed;

  /// Loads identity_ca, identity_certificate, private_key (with password), and the optional
  /// revocation list or trusted_ca_dir; checks that our own CA accepts the certificate at `now`,
  /// and that the certificate belongs to the key. Every error names the property. Errors:
  /// invalid_property (a number, a mode or an interval), those of pki, and trusted_ca_dir_with_crl,
  /// trusted_ca_dir_unreadable, trusted_ca_dir_too_many, own_ca_not_trusted, crl_file_empty,
  /// ocsp_revoked (our own response says so).
  static Result<IdentityFiles> load(const spi::PropertyList& properties, TrustStores& stores,
                                    WallTime now);
};

/// Success if the CAs of the trusted_ca_dir, which is `folder`, include each of our own. Otherwise
/// we would trust peers that do not trust us. Error: own_ca_not_trusted.
Status check_in_trusted_folder(const std::vector<pki::Certificate>& own,
                               const std::vector<pki::Certificate>& trusted,
                               const std::string& folder);

}  // namespace ddssec::authentication
