// The AccessControl interface (DDS-Security 1.2, clause 9.4.2.9), independent of the host.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "base/clock.hpp"
#include "base/hash.hpp"
#include "base/ids.hpp"
#include "plugins/spi/attributes.hpp"
#include "plugins/spi/handles.hpp"
#include "plugins/spi/session_facts.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// What an endpoint requests. The views are borrowed for the call. No partition means the partition
/// "".
struct EndpointRequest {
  std::string_view topic_name;
  std::span<const std::string_view> partitions = {};
  std::span<const Property> data_tags = {};
};

/// Access control for one or several local identities. Each is judged by its own documents. The
/// judgement of a remote identity belongs to one pair of a local and a remote identity.
///
/// Thread-safe. A check returns success, or an error that names the document, line and rule that
/// decided. After every error an event was raised, except where a function says otherwise, and
/// except by return_permissions_handle and by the defaults of optional functions here.
///
/// Every function that takes a permissions handle and returns a Result or a Status, except
/// note_presented, fails with unknown_permissions_handle if the handle was never given out or was
/// returned. Every check that takes a domain fails with other_domain if the handle belongs to
/// another domain.
class AccessControl {
 public:
  virtual ~AccessControl() = default;

  /// Loads the governance, the permissions and the permissions CA that `properties` name
  /// (DDS-Security 1.2, clause 9.4.2.9.1). Finds the grant for the subject of the identity
  /// certificate, which is also named there. A rule counts if its domains include `domain_id` with
  /// `domain_tag`, for remote participants too (DDS-Security 1.2, clause 10.4.1.2.5.1). The caller
  /// owns the handle. Errors: access_not_configured, access_document_missing, missing_property,
  /// governance_not_enforceable, identity_algorithm_not_allowed, trust_chain_algorithm_not_allowed,
  /// those of the documents and certificates (each names its file), no_grant_for_subject,
  /// too_many_permissions_handles.
  virtual Result<PermissionsHandle> validate_local_permissions(
      IdentityHandle identity, DomainId domain_id, const PropertyList& properties,
      std::string_view domain_tag = {}) = 0;
  /// Judges a peer's permissions by the governance and the permissions CA of the local identity
  /// (DDS-Security 1.2, clause 9.4.2.9.2). `credential` holds c.id and c.perm as binary or as text
  /// properties. Each call returns a new handle; the caller returns it. If the governance does not
  /// enable join access control, a peer with unusable permissions also gets a handle: it may then
  /// use unprotected topics only. Errors: unknown_local_identity, identity_algorithm_not_allowed,
  /// trust_chain_algorithm_not_allowed, key_establishment_not_allowed, peer_certificate_missing,
  /// permissions_token_class, permissions_missing, permissions_too_large, those of the certificate
  /// and the document, too_many_permissions_handles.
  virtual Result<PermissionsHandle> validate_remote_permissions(IdentityHandle local_identity,
                                                                IdentityHandle remote_identity,
                                                                const Token& permissions_token,
                                                                const Token& credential) = 0;

  /// Judges a peer by the renewed permissions that it has shown within its session, under the same
  /// handle. `credential` is from Authentication::judge_renewal. Returns true if the peer may have
  /// fewer rights from now on. Errors, which leave the former permissions in force: those of
  /// validate_remote_permissions, permissions_renewal_refused (they begin or were signed earlier
  /// than the former, or the peer has ended).
  virtual Result<bool> renew_remote_permissions(PermissionsHandle,
                                                const Token& /*permissions_token*/,
                                                const Token& /*credential*/) {
    return fail(Code::unknown_permissions_handle);
  }
  /// Notes that the peer has seen renewed permissions of the local identity: its session no longer
  /// ends with the former. `facts` is from Authentication::note_renewal_accepted. Errors:
  /// unknown_local_identity.
  virtual Status note_presented(PermissionsHandle, const SessionFacts&) { return {}; }

  /// Checks whether the local participant may join the domain (DDS-Security 1.2, clause 9.4.2.9.3).
  /// Errors: participant_not_allowed, those of a grant, or of the certificate that signed it, that
  /// is not valid now.
  virtual Status check_create_participant(PermissionsHandle local, DomainId domain_id) = 0;
  /// Checks whether the local participant may have such a writer (DDS-Security 1.2,
  /// clause 9.4.2.9.4). Errors: topic_not_covered, publish_not_allowed, those of the grant as
  /// above.
  virtual Status check_create_datawriter(PermissionsHandle local, DomainId domain_id,
                                         const EndpointRequest& request) = 0;
  /// Checks whether the local participant may have such a reader (DDS-Security 1.2,
  /// clause 9.4.2.9.5). Errors as for a writer, with subscribe_not_allowed instead of
  /// publish_not_allowed.
  virtual Status check_create_datareader(PermissionsHandle local, DomainId domain_id,
                                         const EndpointRequest& request) = 0;
  /// Checks whether the local participant may create the topic (DDS-Security 1.2,
  /// clause 9.4.2.9.6). It may if it may publish or subscribe. Errors: topic_not_covered,
  /// topic_not_allowed, those of the grant as above.
  virtual Status check_create_topic(PermissionsHandle local, DomainId domain_id,
                                    std::string_view topic_name) = 0;

  /// Checks whether a peer may join the domain (DDS-Security 1.2, clause 9.4.2.9.9). The local
  /// governance and the peer's own permissions decide, as in all checks of a peer. Errors:
  /// participant_not_allowed, peer_has_no_permissions, those of the grant as above.
  virtual Status check_remote_participant(PermissionsHandle remote, DomainId domain_id) = 0;
  /// Checks whether a peer may have the announced writer (DDS-Security 1.2, clause 9.4.2.9.10).
  /// Errors: length_out_of_range (names too long or too many partitions), topic_not_covered,
  /// announced_writer_not_allowed, peer_has_no_permissions, those of the grant as above.
  virtual Status check_remote_datawriter(PermissionsHandle remote, DomainId domain_id,
                                         const EndpointRequest& request) = 0;
  /// The answer about a peer's reader.
  struct RemoteDatareader {
    bool is_relay_only = false;
  };
  /// Checks whether a peer may have the announced reader (DDS-Security 1.2, clause 9.4.2.9.11).
  /// `is_relay_only` is true if only a <relay> element allows the reader, so it must not get the
  /// payload key. Errors as for a writer, with announced_reader_not_allowed instead of
  /// announced_writer_not_allowed.
  virtual Result<RemoteDatareader> check_remote_datareader(PermissionsHandle remote,
                                                           DomainId domain_id,
                                                           const EndpointRequest& request) = 0;
  /// A match for which cryptography is about to hand out keys.
  struct Match {
    /// True for the peer's writer and the local reader; false for its reader and the local writer.
    bool remote_writes;
    EndpointRequest local;             ///< the request of the local endpoint
    std::optional<GuidPrefix> remote;  ///< for the event only
    bool remote_hides = false;         ///< see MatchGate::Peer::hides_endpoints
  };
  /// Checks whether a peer may have the keys of this match, whether or not the host asked about the
  /// peer's endpoint. It may if it announced an endpoint of that topic that was allowed, is still
  /// allowed, and has partitions that overlap those of the local endpoint. It may not if it hides
  /// endpoints, because the match may be with one of those. Otherwise the peer is judged as if it
  /// were in the local endpoint's partitions. Once the local participant's permissions were
  /// renewed, they must allow the local endpoint, too. Errors: match_not_permitted; for the local
  /// endpoint publish_not_allowed or subscribe_not_allowed.
  virtual Status check_remote_match(PermissionsHandle remote, const Match& match) = 0;
  /// Checks whether a peer may create the topic (DDS-Security 1.2, clause 9.4.2.9.12). Errors:
  /// length_out_of_range, topic_not_covered, topic_not_allowed, peer_has_no_permissions, those of
  /// the grant as above.
  virtual Status check_remote_topic(PermissionsHandle remote, DomainId domain_id,
                                    std::string_view topic_name) = 0;

  /// Returns the PermissionsToken that discovery announces (DDS-Security 1.2, clause 9.4.2.9.17).
  virtual Result<Token> permissions_token(PermissionsHandle local) = 0;
  /// Returns the signed permissions document in property dds.perm.cert, for
  /// Authentication::set_permissions_credential_and_token (DDS-Security 1.2, clause 9.4.2.9.18).
  virtual Result<Token> permissions_credential_token(PermissionsHandle local) = 0;

  /// Returns the number of times that `poll` has taken renewed permissions of a local
  /// participant. When it grows, the host passes the new permissions_credential_token to
  /// authentication. 0 for any other handle.
  virtual std::uint64_t renewals(PermissionsHandle) { return 0; }
  /// Checks an endpoint that exists, as check_create_datawriter (`writes`) or
  /// check_create_datareader does. No event is raised.
  virtual Status check_own_endpoint(PermissionsHandle, bool /*writes*/, const EndpointRequest&) {
    return fail(Code::unknown_permissions_handle);
  }
  /// An endpoint of the application.
  struct OwnEndpoint {
    bool writes;
    EndpointRequest request;
  };
  /// Returns the index of the first of the endpoints that a peer that runs ddssec does not match,
  /// because it knows only former permissions of the local participant. The caller then ends the
  /// sessions: a peer that stays nevertheless does not count again. No event is raised.
  virtual std::optional<std::size_t> find_unknown_right(PermissionsHandle /*local*/,
                                                        std::span<const OwnEndpoint>) {
    return std::nullopt;
  }

  /// A governance document: its revision (0 if it has none) and the digest of its signed text.
  struct GovernanceVersion {
    std::uint32_t revision = 0;
    Sha256Digest digest{};
    bool operator==(const GovernanceVersion&) const = default;
  };
  /// Returns the version in force. Empty for an unknown handle.
  virtual std::optional<GovernanceVersion> governance_version(PermissionsHandle) { return {}; }
  /// Returns the version of a document that `poll` has taken, and that protects topics in use or
  /// the whole domain more. It waits until the host has changed what it protects. Until then the
  /// document in force decides everything. Empty if none waits.
  virtual std::optional<GovernanceVersion> pending_governance(PermissionsHandle) { return {}; }
  /// Returns the participant's attributes under the document of that version. Empty unless it is
  /// the pending one, or the one before the last that waited.
  virtual std::optional<ParticipantSecurityAttributes> participant_attributes_of(
      PermissionsHandle, const GovernanceVersion&) {
    return {};
  }
  /// Returns the attributes of an endpoint of the topic, which may be a builtin one, under the same
  /// document. Also empty if it has no rule for the topic.
  virtual std::optional<EndpointSecurityAttributes> endpoint_attributes_of(PermissionsHandle,
                                                                           const GovernanceVersion&,
                                                                           std::string_view) {
    return {};
  }
  /// Returns the rights of an endpoint of the peer under the pending document. `writes` is true for
  /// a DataWriter. Empty if it may not match, or if no document waits.
  virtual std::optional<RemoteDatareader> pending_permission(PermissionsHandle, bool /*writes*/,
                                                             const EndpointRequest&) {
    return {};
  }
  /// Puts the document that waited into force. Returns false, and does nothing, if that version
  /// does not wait.
  virtual bool apply_pending_governance(PermissionsHandle, const GovernanceVersion&) {
    return false;
  }

  /// Returns the demands of the governance for the participant (DDS-Security 1.2,
  /// clause 9.4.2.9.22).
  virtual Result<ParticipantSecurityAttributes> participant_sec_attributes(
      PermissionsHandle local) = 0;
  /// Returns the demands of the governance for a topic (DDS-Security 1.2, clause 9.4.2.9.23).
  /// Error: topic_not_covered.
  virtual Result<TopicSecurityAttributes> topic_sec_attributes(PermissionsHandle local,
                                                               std::string_view topic_name) = 0;
  /// Returns the demands of the governance for a writer (DDS-Security 1.2, clause 9.4.2.9.24). Also
  /// answers for the builtin secure topics (DDS-Security 1.2, clause 7.5.13). Error:
  /// topic_not_covered.
  virtual Result<EndpointSecurityAttributes> datawriter_sec_attributes(
      PermissionsHandle local, const EndpointRequest& request) = 0;
  /// Returns the demands of the governance for a reader (DDS-Security 1.2, clause 9.4.2.9.25).
  /// Otherwise as for a writer.
  virtual Result<EndpointSecurityAttributes> datareader_sec_attributes(
      PermissionsHandle local, const EndpointRequest& request) = 0;

  /// Returns the same as datareader_sec_attributes, for a host that does not keep the answer. The
  /// topic does not count as in use, so later governance documents may change its protection in any
  /// way. Use this for a topic that only peers have named. Raises no event for topic_not_covered.
  virtual Result<EndpointSecurityAttributes> unused_topic_attributes(
      PermissionsHandle local, std::string_view topic_name) = 0;
  /// Notes that the host has no endpoint on the topic any more, and keeps no attributes of it. The
  /// topic no longer counts as in use. Hosts that never call this keep all topics in use.
  virtual void forget_topic(PermissionsHandle local, std::string_view topic_name) = 0;

  /// Drops a handle. Error, without an event: unknown_permissions_handle.
  virtual Status return_permissions_handle(PermissionsHandle permissions) = 0;

  /// Returns the time when the next grant in use ends, or the certificate that signed it; empty if
  /// none does.
  virtual std::optional<WallTime> next_expiry() = 0;
  /// First takes other permissions CAs, a changed governance and renewed permissions of local
  /// participants from the files that their properties name, if these have changed. No other call
  /// reads files later on. Then raises the events for permissions that ended or whose CA was
  /// removed from the file, and returns their handles, each once. The host then revokes them. As
  /// with Authentication::poll, a local participant's handle is followed by those of its peers.
  /// An exception are peers for whose remote identity another local participant has permissions
  /// too: a host that gives all its participants one remote identity (Cyclone DDS) can only remove
  /// such a peer for all of them. If `local` is not nil, only that handle and those of its peers
  /// are checked.
  virtual std::vector<PermissionsHandle> poll(PermissionsHandle local = {}) = 0;
};

}  // namespace ddssec::spi
