// What a secured participant is to the three plugins: its identity, permissions and keys.
#pragma once

#include <memory>
#include <string_view>

#include "base/ids.hpp"
#include "plugins/spi/access_control.hpp"
#include "plugins/spi/authentication.hpp"
#include "plugins/spi/cryptography.hpp"

namespace ddssec::rtps {

/// The engines, made by the application; they outlive every participant that uses them.
struct SecurityPlugins {
  spi::Authentication& authentication;
  spi::AccessControl& access_control;
  spi::Cryptography& cryptography;
};

/// What makes a participant a secured one.
struct SecurityOptions {
  SecurityPlugins plugins;
  /// Names as in plugins/spi/property_names.hpp.
  spi::PropertyList properties;
};

/// A local participant that is allowed to be there. Gives its handles back when it dies.
class OwnSecurity {
 public:
  /// Errors: those of the plugins (each has raised its event already).
  static Result<std::unique_ptr<OwnSecurity>> create(const SecurityOptions& options,
                                                     DomainId domain_id,
                                                     const GuidPrefix& candidate,
                                                     std::string_view domain_tag = {});
  ~OwnSecurity();
  OwnSecurity(const OwnSecurity&) = delete;
  OwnSecurity& operator=(const OwnSecurity&) = delete;

  SecurityPlugins& plugins() { return options_.plugins; }
  const spi::PropertyList& properties() const { return options_.properties; }
  DomainId domain_id() const { return domain_id_; }
  const std::string& domain_tag() const { return domain_tag_; }
  /// Bound to the certificate's subject (DDS-Security 9.3.3).
  const Guid& guid() const { return guid_; }
  spi::IdentityHandle identity() const { return identity_; }
  spi::PermissionsHandle permissions() const { return permissions_; }
  spi::ParticipantCryptoHandle crypto() const { return crypto_; }
  const spi::ParticipantSecurityAttributes& attributes() const { return attributes_; }
  const spi::SymmetricCipherInfo& ciphers() const { return ciphers_; }
  /// nullptr: the governance asks for none.
  spi::PreSharedKeys* pre_shared_keys() const { return pre_shared_keys_.get(); }
  const spi::Token& identity_token() const { return identity_token_; }
  const spi::Token& permissions_token() const { return permissions_token_; }

  /// What the governance says of one of the builtin topics of DDS-Security 7.4.8.
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
  spi::ParticipantCryptoHandle crypto_;
  spi::ParticipantSecurityAttributes attributes_;
  spi::SymmetricCipherInfo ciphers_;
  std::unique_ptr<spi::PreSharedKeys> pre_shared_keys_;
  spi::Token identity_token_, permissions_token_;
};

}  // namespace ddssec::rtps
