#include "rtps/security/own_security.hpp"

namespace ddssec::rtps {

Result<std::unique_ptr<OwnSecurity>> OwnSecurity::create(const SecurityOptions& options,
                                                         DomainId domain_id,
                                                         const GuidPrefix& candidate,
                                                         std::string_view domain_tag) {
  std::unique_ptr<OwnSecurity> out(new OwnSecurity(options, domain_id, domain_tag));
  DDSSEC_TRY(out->authenticate(candidate));
  DDSSEC_TRY(out->authorize());
  DDSSEC_TRY(out->share_keys());
  return out;
}

OwnSecurity::~OwnSecurity() {
  auto& [authentication, access_control, cryptography] = options_.plugins;
  if (crypto_) static_cast<void>(cryptography.key_factory().unregister_participant(crypto_));
  if (permissions_) static_cast<void>(access_control.return_permissions_handle(permissions_));
  if (identity_) static_cast<void>(authentication.return_identity_handle(identity_));
}

Status OwnSecurity::authenticate(const GuidPrefix& candidate) {
  auto& plugin = options_.plugins.authentication;
  const auto local = DDSSEC_TRY(plugin.validate_local_identity(domain_id_, options_.properties,
                                                               {candidate, kEntityIdParticipant}));
  identity_ = local.handle;
  guid_ = local.adjusted_guid;
  identity_token_ = DDSSEC_TRY(plugin.identity_token(
      identity_, options_.plugins.cryptography.key_factory().supported_ciphers()));
  return {};
}

Status OwnSecurity::authorize() {
  auto& [authentication, access_control, cryptography] = options_.plugins;
  permissions_ = DDSSEC_TRY(access_control.validate_local_permissions(
      identity_, domain_id_, options_.properties, domain_tag_));
  DDSSEC_TRY(access_control.check_create_participant(permissions_, domain_id_));
  permissions_token_ = DDSSEC_TRY(access_control.permissions_token(permissions_));
  const auto credential = DDSSEC_TRY(access_control.permissions_credential_token(permissions_));
  DDSSEC_TRY(authentication.set_permissions_credential_and_token(identity_, credential,
                                                                 permissions_token_));
  attributes_ = DDSSEC_TRY(access_control.participant_sec_attributes(permissions_));
  crypto_ = DDSSEC_TRY(cryptography.key_factory().register_local_participant(
      identity_, permissions_, options_.properties, attributes_));
  ciphers_ = DDSSEC_TRY(cryptography.key_factory().cipher_info(crypto_));
  return {};
}

Status OwnSecurity::share_keys() {
  if (!is_protected(attributes_.rtps_psk)) return {};
  pre_shared_keys_ = DDSSEC_TRY(options_.plugins.cryptography.key_factory().pre_shared_keys(
      {options_.properties, attributes_, domain_id_, domain_tag_}));
  return {};
}

void OwnSecurity::present_renewed_permissions() {
  auto& [authentication, access_control, cryptography] = options_.plugins;
  const auto renewals = access_control.renewals(permissions_);
  if (renewals == renewals_) return;
  renewals_ = renewals;
  if (const auto credential = access_control.permissions_credential_token(permissions_))
    static_cast<void>(authentication.set_permissions_credential_and_token(identity_, *credential,
                                                                          permissions_token_));
}

Result<spi::EndpointSecurityAttributes> OwnSecurity::builtin_attributes(std::string_view topic) {
  return options_.plugins.access_control.datawriter_sec_attributes(permissions_,
                                                                   {.topic_name = topic});
}

}  // namespace ddssec::rtps
