// The local participant's handles at the three plugins: its identity, permissions and keys.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string_view>

#include "base/ids.hpp"
#include "plugins/spi/access_control.hpp"
#include "plugins/spi/authentication.hpp"
#include "plugins/spi/cryptography.hpp"
#include "plugins/spi/shared_memory.hpp"
#include "rtps/security/security_options.hpp"
#include "rtps/security/session_ends.hpp"

namespace ddssec::rtps {

/// A local participant that was authenticated and authorized. Its destructor returns the handles.
class OwnSecurity {
 public:
  /// Authenticates and authorizes the local participant. Errors: those of the plugins, which have
  /// already raised their events.
  static Result<std::unique_ptr<OwnSecurity>> create(const SecurityOptions& options,
                                                     DomainId domain_id,
                                                     const GuidPrefix& candidate,
                                                     std::string_view domain_tag = {});
  ~OwnSecurity();
  OwnSecurity(const OwnSecurity&) = delete;
  OwnSecurity& operator=(const OwnSecurity&) = delete;

  SecurityPlugins& plugins() { return options_.plugins; }
  const spi::PropertyList& properties() const { return options_.properties; }
  /// See spi::governance_change_time.
  std::chrono::seconds governance_change_time() const { return governance_change_time_; }
  /// See spi::shared_memory.
  const spi::SharedMemory& shared_memory() const { return shared_memory_; }
  /// See spi::busy_wait.
  std::optional<std::chrono::microseconds> busy_wait() const { return busy_wait_; }
  SessionEnds& session_ends() { return session_ends_; }
  DomainId domain_id() const { return domain_id_; }
  const std::string& domain_tag() const { return domain_tag_; }
  /// Returns the GUID, which is bound to the certificate's subject (DDS-Security 1.2,
  /// clause 10.3.3).
  const Guid& guid() const { return guid_; }
  spi::IdentityHandle identity() const { return identity_; }
  spi::PermissionsHandle permissions() const { return permissions_; }
  spi::ParticipantCryptoHandle crypto() const { return crypto_; }
  const spi::ParticipantSecurityAttributes& attributes() const { return attributes_; }
  const spi::SymmetricCipherInfo& ciphers() const { return ciphers_; }
  /// Returns nullptr if the governance requires no pre-shared keys.
  spi::PreSharedKeys* pre_shared_keys() const { return pre_shared_keys_.get(); }
  const spi::Token& identity_token() const { return identity_token_; }
  const spi::Token& permissions_token() const { return permissions_token_; }

  /// Sets the attributes that the governance demands from now on. Returns the former ones.
  spi::ParticipantSecurityAttributes set_attributes(
      const spi::ParticipantSecurityAttributes& attributes) {
    return std::exchange(attributes_, attributes);
  }

  /// Makes handshakes present permissions that access control has renewed, from now on. An event
  /// reports a refusal. Returns true if there are any.
  bool present_renewed_permissions();

  /// Returns the governance's attributes for one of the builtin topics of DDS-Security 1.2,
  /// clause 7.5.13.
  Result<spi::EndpointSecurityAttributes> builtin_attributes(std::string_view topic);

 private:
  OwnSecurity(const SecurityOptions& options, DomainId domain_id, std::string_view domain_tag)
      : options_(options), domain_id_(domain_id), domain_tag_(domain_tag) {}
  Status authenticate(const GuidPrefix& candidate);
  Status authorize();
  Status share_keys();

  SecurityOptions options_;
  const DomainId domain_id_;
  const std::string domain_tag_;
  Guid guid_;
  spi::IdentityHandle identity_;
  spi::PermissionsHandle permissions_;
  std::uint64_t renewals_ = 0;  ///< number of renewals of the permissions that authentication has
  spi::ParticipantCryptoHandle crypto_;
  spi::ParticipantSecurityAttributes attributes_;
  spi::SymmetricCipherInfo ciphers_;
  std::chrono::seconds governance_change_time_{};
  spi::SharedMemory shared_memory_;
  std::optional<std::chrono::microseconds> busy_wait_;
  std::unique_ptr<spi::PreSharedKeys> pre_shared_keys_;
  spi::Token identity_token_, permissions_token_;
  SessionEnds session_ends_;
};

}  // namespace ddssec::rtps
