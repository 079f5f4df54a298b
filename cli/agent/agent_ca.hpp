// The CA in a folder of this machine, as the agent uses it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "cli/agent/agent_folder.hpp"
#include "cli/agent/agent_messages.hpp"
#include "cli/frame/command.hpp"
#include "pki/chain.hpp"

namespace ddssec::cli {

/// Issues the certificate that follows the one in a participant's folder, by the rules of `identity
/// renew`: the CA (--ca) issued the old one for this folder and did not revoke it. Subject and key
/// stay; with --rekey the new key is that of the request. The certificate is valid for --days, or
/// as long as the old one. With --permissions, permissions that end before it are extended, and the
/// answer gives the reason if they cannot be. If only they are due and cannot be extended, no
/// certificate is issued. They must be the last that the CA signed for a file
/// (signed.jsonl). If the CA can issue no certificate with a later end, but can extend the
/// permissions, the answer has the old certificate. Errors: those of CaOpener, check_issued_for,
/// check_renewal_request, Authority::sign_request; renewal_goes_back, outlives_ca, ends_before_ca.
Result<RenewalAnswer> renew_by_ca(const RenewalRequest& request,
                                  const std::filesystem::path& folder, const Arguments& arguments,
                                  const Context& context);

/// The renewal list of the CAs at --ca.
struct RenewalListOfCa {
  std::string text = {};              ///< empty if there is no list that a worker can get
  std::optional<Error> problem = {};  ///< why folders do not get the list, or a part of it
};
/// Reads that list. A list that does not fit into a line to a worker is a problem: file_too_large.
/// The other problems are those of renewals_of.
RenewalListOfCa renewal_list_of_ca(const Arguments& arguments);

/// Success if the passphrase of the options opens the keys of --ca (with --permissions both), as
/// far as that can be tried. A key in a token is not tried, because a wrong PIN may lock the token,
/// nor is a passphrase that is typed or comes from a pipe. Errors: those of passphrase() and
/// read_key.
Status check_passphrase(const Arguments& arguments);

/// Reads the revocation lists in a file. Errors: those of read_file and Crl::all_from.
Result<std::vector<pki::Crl>> read_lists(const std::filesystem::path& file);

/// Success if no list of the verifier, from `file`, names the certificate. Error:
/// certificate_revoked.
Status check_not_on(const pki::ChainVerifier& verifier, const pki::Certificate& certificate,
                    const std::filesystem::path& file);

/// Success if the folder of this owner may ask the CA or a hook. Another user could ask for any
/// name, with a certificate of their own in the folder or with a copy of another participant's.
/// Only a signature by the present key proves which participant asks. Error: folder_untrusted.
Status check_owner(const FolderOwner& owner, const Arguments& arguments,
                   const std::filesystem::path& folder);

/// The CAs whose certificates an agent with a hook renews, and their revocation lists.
struct TrustedRequesters {
  std::filesystem::path trust;  ///< a file with CAs; empty: all CAs are trusted
  /// Revocation lists of these CAs; empty: crl.pem beside `trust`, if there is one.
  std::filesystem::path lists;
  /// The last certificate that a hook gave for the subject, PEM; empty: not known.
  std::string last = {};
  bool may_have_expired = false;  ///< their certificates, which the lists may not name any more
};
/// Returns the file with the lists that check_requester looks into. Empty if there is none: then it
/// checks no revocation.
std::filesystem::path lists_file(const TrustedRequesters& trusted);

/// Success if a request may be given to a hook: it has the subject of the certificate in the folder
/// and, unless `is_rekeying`, its key. One of the trusted CAs must have issued the certificate,
/// which has not expired, and none of the lists names it or the last one of its subject. Otherwise
/// the owner of a folder could ask for any name, or continue after a revocation. Errors: those of
/// check_renewal_request, check_trust_file, read_certificates and read_lists; issuer_unknown,
/// certificate_expired, certificate_revoked.
Status check_requester(const RenewalRequest& request, const TrustedRequesters& trusted,
                       bool is_rekeying, WallTime now);

}  // namespace ddssec::cli
