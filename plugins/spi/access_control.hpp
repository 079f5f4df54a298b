// The AccessControl interface (DDS-Security 8.4.2.9), for a host of any make.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.hpp"
#include "base/ids.hpp"
#include "plugins/spi/attributes.hpp"
#include "plugins/spi/handles.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// What an endpoint asks for. Views are borrowed for the call. No partition means the partition "".
struct EndpointRequest {
  std::string_view topic_name;
  std::span<const std::string_view> partitions = {};
  std::span<const Property> data_tags = {};
};

/// One engine may serve several local identities, each by its own documents; what is judged of a
/// remote identity belongs to the pair of the two.
///
/// Thread-safe. Every check is success, or an error that names document, line and rule that
/// decided.
class AccessControl {
 public:
  virtual ~AccessControl() = default;

  /// Loads governance, permissions and permissions CA named by `properties` and finds the grant of
  /// the subject in the identity certificate, also named there. Rules count if their domains
  /// include `domain_id` with `domain_tag`, for remote participants too
  /// (DDS-Security 1.2 10.4.1.2.5.1).
  virtual Result<PermissionsHandle> validate_local_permissions(
      IdentityHandle identity, DomainId domain_id, const PropertyList& properties,
      std::string_view domain_tag = {}) = 0;
  /// `credential` holds c.id and c.perm as binary or as text properties. Judges the remote's
  /// permissions by the governance and the permissions CA of the local identity. Each call gives
  /// out a handle of its own, to be returned by who called.
  virtual Result<PermissionsHandle> validate_remote_permissions(IdentityHandle local_identity,
                                                                IdentityHandle remote_identity,
                                                                const Token& permissions_token,
                                                                const Token& credential) = 0;

  virtual Status check_create_participant(PermissionsHandle local, DomainId domain_id) = 0;
  virtual Status check_create_datawriter(PermissionsHandle local, DomainId domain_id,
                                         const EndpointRequest& request) = 0;
  virtual Status check_create_datareader(PermissionsHandle local, DomainId domain_id,
                                         const EndpointRequest& request) = 0;
  virtual Status check_create_topic(PermissionsHandle local, DomainId domain_id,
                                    std::string_view topic_name) = 0;

  virtual Status check_remote_participant(PermissionsHandle remote, DomainId domain_id) = 0;
  virtual Status check_remote_datawriter(PermissionsHandle remote, DomainId domain_id,
                                         const EndpointRequest& request) = 0;
  struct RemoteDatareader {
    bool relay_only = false;
  };
  virtual Result<RemoteDatareader> check_remote_datareader(PermissionsHandle remote,
                                                           DomainId domain_id,
                                                           const EndpointRequest& request) = 0;
  /// A match as cryptography is about to give it keys.
  struct Match {
    bool remote_writes;                ///< to our reader, or else it reads from our writer
    EndpointRequest local;             ///< what our own endpoint asks for
    std::optional<GuidPrefix> remote;  ///< for the event
  };
  /// May a peer have the keys of this match, whether or not the host asked about its endpoint? By
  /// what it announced, if that was allowed and meets our partitions, or else as if it were in our
  /// endpoint's partitions. Error: match_not_permitted, unknown_permissions_handle.
  virtual Status check_remote_match(PermissionsHandle remote, const Match& match) = 0;
  virtual Status check_remote_topic(PermissionsHandle remote, DomainId domain_id,
                                    std::string_view topic_name) = 0;

  virtual Result<Token> permissions_token(PermissionsHandle local) = 0;
  virtual Result<Token> permissions_credential_token(PermissionsHandle local) = 0;

  virtual Result<ParticipantSecurityAttributes> participant_sec_attributes(
      PermissionsHandle local) = 0;
  virtual Result<TopicSecurityAttributes> topic_sec_attributes(PermissionsHandle local,
                                                               std::string_view topic_name) = 0;
  /// Also answers for the builtin secure topics (DDS-Security 7.4.8, 8.4.2.9.24).
  virtual Result<EndpointSecurityAttributes> datawriter_sec_attributes(
      PermissionsHandle local, const EndpointRequest& request) = 0;
  virtual Result<EndpointSecurityAttributes> datareader_sec_attributes(
      PermissionsHandle local, const EndpointRequest& request) = 0;

  virtual Status return_permissions_handle(PermissionsHandle permissions) = 0;

  /// When the next grant in use ends, if any; `expire` raises the events and returns the handles to
  /// be revoked, each once; a local participant's is followed by those of its peers, as with
  /// Authentication::expire, but for peers under whose remote identity another local participant
  /// has permissions too: a host that gives all its participants one remote identity (Cyclone DDS)
  /// can only remove the peer for all of them. `local`: that handle and those of its peers only;
  /// nil: all.
  virtual std::optional<WallTime> next_expiry() = 0;
  virtual std::vector<PermissionsHandle> expire(PermissionsHandle local = {}) = 0;
};

}  // namespace ddssec::spi
