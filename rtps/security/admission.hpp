// Decides which participants may try to authenticate, and which endpoints may be created and
// matched (DDS-Security 1.2, clauses 9.8.3, 9.8.6, 9.8.7).
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "rtps/discovery/endpoint_data.hpp"
#include "rtps/security/security_core.hpp"

namespace ddssec::rtps {

/// Asks access control, and remembers the parameters with which the local endpoints were created.
class Admission {
 public:
  explicit Admission(SecurityCore& core) : core_(core) {}

  enum class Decision { authenticate, admit_unauthenticated, refuse };
  /// Decides what to do with a participant that announced itself. A refusal raises an event.
  Decision judge(const ParticipantData& data);
  /// True if the participant announces that it can authenticate, with attributes that the local
  /// governance accepts.
  bool may_authenticate(const ParticipantData& data) const;
  /// True if participants may join without authentication: the governance allows it, and messages
  /// are not protected.
  bool admits_unauthenticated() const;
  /// Checks the data that the participant signed in the way that `judge` checks announcements, and
  /// also its domain. Errors: rtps_key_revision_mismatch, rtps_security_info_mismatch,
  /// rtps_cipher_unsupported, rtps_domain_differs (which raises an event).
  Status check_proven(const ParticipantData& proven) const;

  /// A remote endpoint. `is_secure` is true if secure SEDP announced it.
  struct Endpoint {
    Guid guid;
    std::string_view topic;
    const std::vector<std::string>& partitions;
    const spi::PropertyList& data_tags;
    spi::SecurityInfo info;
    bool is_secure = false;
    std::optional<spi::CipherMask> required_ciphers = {};
    /// Returns the endpoint as it was announced.
    static Endpoint of(const EndpointData& announced);
  };
  struct Permission {
    bool is_relay_only = false;
  };
  /// Returns the permission of the remote endpoint to match the local one. Without it, returns
  /// nothing, and an event reports the reason.
  std::optional<Permission> admit(const EntityId& local, const Endpoint& remote);
  /// True if the remote writer may match a local reader that could be created for it. If not, an
  /// event reports the reason.
  bool may_write(const Endpoint& writer);

  struct NewEndpoint {
    std::string_view topic;
    const std::vector<std::string>& partitions;
    const spi::PropertyList& data_tags;
    const spi::PropertyList& properties;
  };
  /// The security data with which discovery announces a local endpoint.
  struct AnnouncedSecurity {
    std::optional<spi::SecurityInfo> info;
    std::optional<spi::CipherMask> required_ciphers;
    bool key_is_protected = false;
  };
  /// Checks whether the local endpoint may be created, and registers it. Errors: those of access
  /// control and cryptography.
  Result<AnnouncedSecurity> create_endpoint(const EntityId& id, const NewEndpoint& endpoint);
  /// Success if our permissions allow the local endpoint in these partitions. Errors: those of
  /// access control.
  Status check_partitions(const EntityId& id, const std::vector<std::string>& partitions);
  /// Notes that the endpoint is in these partitions from now on.
  void set_partitions(const EntityId& id, const std::vector<std::string>& partitions);
  /// Notes a secure builtin endpoint of the middleware; create_endpoint() is not called for it.
  void note_builtin(const EntityId& id, std::string_view topic) {
    builtin_topics_.emplace_back(id, topic);
  }
  const std::vector<std::pair<EntityId, std::string>>& builtin_topics() const {
    return builtin_topics_;
  }
  /// Returns the local endpoints of the application and their topics.
  std::vector<std::pair<EntityId, std::string>> own_topics() const;
  /// Gives the endpoint the protection of the other document too, while the governance changes.
  /// Does nothing if the endpoint has a second protection already, or if the two are equal. Error:
  /// that of cryptography.
  Status add_other_protection(const EntityId& id, std::string_view topic);
  /// The functions that announce local endpoints while the governance changes.
  struct Announcements {
    std::function<void()> announce;      ///< called when their protection has changed
    std::function<bool()> are_received;  ///< true if peers with the document have what moved
    std::function<void()> end_former;    ///< called when unprotected ones are superfluous
  };
  void announce_with(Announcements announcements) { announcements_ = std::move(announcements); }
  void announce_protection() const {
    if (announcements_.announce) announcements_.announce();
  }
  bool are_announcements_received() const {
    return !announcements_.are_received || announcements_.are_received();
  }
  void end_former_announcements() const {
    if (announcements_.end_former) announcements_.end_former();
  }
  /// Returns the data with which discovery announces a local endpoint now. Error: that of
  /// cryptography.
  Result<AnnouncedSecurity> announced(const EntityId& id);
  /// Forgets an endpoint that is gone. Its topic no longer counts as in use if no other local
  /// endpoint is on it.
  void forget_endpoint(const EntityId& id);

 private:
  /// The parameters with which a local endpoint was created.
  struct CreationParameters {
    std::string topic;
    std::vector<std::string> partitions;
    spi::PropertyList data_tags;
  };
  /// The attributes of an endpoint of the topic under the other document, while the governance
  /// changes.
  std::optional<spi::EndpointSecurityAttributes> other_attributes(std::string_view topic) const;
  Status check_own(const EntityId& id, const NewEndpoint& endpoint);
  /// True unless our own permissions were renewed, or the governance changed, and they no longer
  /// allow the endpoint. An event reports that.
  bool may_still(const EntityId& id);
  bool permits_under_pending_governance(bool reads, const Permission& permission,
                                        const Endpoint& remote);
  Status check_ciphers(VendorId vendor, spi::CipherMask required) const;
  Status check_participant(const ParticipantData& data) const;
  Status check_domain(const ParticipantData& proven) const;
  /// A local endpoint, whether it exists or not.
  struct Local {
    const spi::EndpointSecurityAttributes& attributes;
    bool reads;
    /// The attributes under the other document while the governance changes, or nullptr.
    const spi::EndpointSecurityAttributes* other = nullptr;
  };
  std::optional<Permission> admit(const Local& local, const Endpoint& remote);
  Status check_open(const spi::EndpointSecurityAttributes& attributes,
                    const Endpoint& remote) const;
  Status check_protection(const Local& local, const Endpoint& remote, const Peer& peer) const;
  static Status check_announced(const spi::EndpointSecurityAttributes& attributes,
                                const Endpoint& remote);
  Result<Permission> check_permissions(const Local& local, const Association& peer,
                                       const Endpoint& remote);

  SecurityCore& core_;
  std::map<EntityId, CreationParameters> own_;
  std::map<std::string, std::size_t, std::less<>> endpoints_on_;  ///< number of own_, by topic
  std::vector<std::pair<EntityId, std::string>> builtin_topics_;
  Announcements announcements_;
};

}  // namespace ddssec::rtps
