// Loads properties and tokens into verified documents.
#pragma once

#include <memory>

#include "plugins/access_control/access_control.hpp"
#include "plugins/access_control/permissions_holder.hpp"

namespace ddssec::access_control {

/// The data that loading needs besides its arguments.
struct LoadContext {
  DocumentCache& documents;
  const AccessControlOptions& options;
  WallTime now;
};

/// The data that compiling a governance document needs besides it.
struct GovernanceContext {
  const PermissionsCa& ca;
  const LocalParticipant& participant;
  const AccessControlOptions& options;
};
/// A governance document whose signature by the permissions CA was verified.
struct VerifiedGovernance {
  std::shared_ptr<const governance::CompiledGovernance> rules;
  Sha256Digest digest;  ///< digest of the signed text
};
/// Returns the rule for the participant's domain, from a signed file. Errors: those of
/// pki::DocumentVerifier::verify, governance::read_governance and CompiledGovernance::make,
/// governance_not_enforceable.
Result<VerifiedGovernance> compile_governance(const GovernanceContext& context, BytesView file,
                                              WallTime now);

/// Reads what the properties name: certificate, permissions CA, governance and permissions, and
/// finds the grant. Errors: access_not_configured, access_document_missing, missing_property,
/// governance_not_enforceable, identity_algorithm_not_allowed, trust_chain_algorithm_not_allowed,
/// and those of the documents; each names the file.
Result<std::shared_ptr<PermissionsHolder>> load_local(const LoadContext& context,
                                                      spi::IdentityHandle identity, DomainId domain,
                                                      const spi::PropertyList& properties,
                                                      std::string_view domain_tag);

/// Returns a peer's document as `local` judges it. `subject` is set as soon as it is known, for the
/// event about an error. No data of the peer is kept unless the document is verified. Errors:
/// permissions_token_class, peer_certificate_missing, permissions_missing, permissions_too_large,
/// and those of certificate and document.
Result<std::shared_ptr<PermissionsDocument>> judge_remote(const LoadContext& context,
                                                          const LocalParticipant& local,
                                                          const spi::Token& permissions_token,
                                                          const spi::Token& credential,
                                                          HolderSubject& subject);

/// Checks a peer's identity and its handshake against <allowed_crypto_algorithms>; `subject` as
/// above. Success if the credential has no certificate, because judge_remote refuses that. Errors:
/// those of allowed_algorithms.hpp, of Certificate::from_pem.
Status check_remote_algorithms(const LocalParticipant& local, const spi::Token& credential,
                               HolderSubject& subject);

}  // namespace ddssec::access_control
