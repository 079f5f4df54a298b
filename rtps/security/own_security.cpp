#include "rtps/security/own_security.hpp"

#include "plugins/spi/busy_wait.hpp"
#include "plugins/spi/governance_change_time.hpp"

namespace ddssec::rtps {

Result<std::unique_ptr<OwnSecurity>> OwnSecurity::create(const SecurityOptions& options,
                                                         DomainId domain_id,
                                                         const GuidPrefix& candidate,
                                                         std::string_view domain_tag) {
  std::unique_ptr<OwnSecurity> out(new OwnSecurity(options, domain_id, domain_tag));
  DDSSEC_ASSIGN_OR_RETURN(out->governance_change_time_,
                          spi::governance_change_time(options.properties));
  DDSSEC_ASSIGN_OR_RETURN(out->shared_memory_, spi::shared_memory(options.properties));
  DDSSEC_ASSIGN_OR_RETURN(out->busy_wait_, spi::busy_wait(options.properties));
  DDSSEC_RETURN_IF_ERROR(out->authenticate(candidate));
  DDSSEC_RETURN_IF_ERROR(out->authorize());
  DDSSEC_RETURN_IF_ERROR(out->share_keys());
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
  DDSSEC_ASSIGN_OR_RETURN(const auto local,
                          plugin.validate_local_identity(domain_id_, options_.properties,
                                                         {candidate, kEntityIdParticipant}));
  identity_ = local.handle;
  guid_ = local.adjusted_guid;
  DDSSEC_ASSIGN_OR_RETURN(
      identity_token_,
      plugin.identity_token(identity_,
                            options_.plugins.cryptography.key_factory().supported_ciphers()));
  return {};
}

Status OwnSecurity::authorize() {
  auto& [authentication, access_control, cryptography] = options_.plugins;
  DDSSEC_ASSIGN_OR_RETURN(
      permissions_, access_control.validate_local_permissions(identity_, domain_id_,
                                                              options_.properties, domain_tag_));
  DDSSEC_RETURN_IF_ERROR(access_control.check_create_participant(permissions_, domain_id_));
  DDSSEC_ASSIGN_OR_RETURN(permissions_token_, access_control.permissions_token(permissions_));
  DDSSEC_ASSIGN_OR_RETURN(const auto credential,
                          access_control.permissions_credential_token(permissions_));
  DDSSEC_RETURN_IF_ERROR(authentication.set_permissions_credential_and_token(identity_, credential,
                                                                             permissions_token_));
  DDSSEC_ASSIGN_OR_RETURN(attributes_, access_control.participant_sec_attributes(permissions_));
  DDSSEC_ASSIGN_OR_RETURN(crypto_, cryptography.key_factory().register_local_participant(
                                       identity_, permissions_, options_.properties, attributes_));
  DDSSEC_ASSIGN_OR_RETURN(ciphers_, cryptography.key_factory().cipher_info(crypto_));
  return {};
}

Status OwnSecurity::share_keys() {
  if (!is_protected(attributes_.rtps_psk)) return {};
  DDSSEC_ASSIGN_OR_RETURN(pre_shared_keys_,
                          options_.plugins.cryptography.key_factory().pre_shared_keys(
                              {options_.properties, attributes_, domain_id_, domain_tag_}));
  return {};
}

bool OwnSecurity::present_renewed_permissions() {
  auto& [authentication, access_control, cryptography] = options_.plugins;
  const auto renewals = access_control.renewals(permissions_);
  if (renewals == renewals_) return false;
  renewals_ = renewals;
  if (const auto credential = access_control.permissions_credential_token(permissions_))
    static_cast<void>(authentication.set_permissions_credential_and_token(identity_, *credential,
                                                                          permissions_token_));
  return true;
}

Result<spi::EndpointSecurityAttributes> OwnSecurity::builtin_attributes(std::string_view topic) {
  return options_.plugins.access_control.datawriter_sec_attributes(permissions_,
                                                                   {.topic_name = topic});
}

}  // namespace ddssec::rtps
