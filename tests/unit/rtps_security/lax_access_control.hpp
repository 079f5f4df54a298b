// Access control that allows its own participant everything, as an attacker's would. The tests look
// at what other participants do about it.
#pragma once

#include <memory>

#include "plugins/spi/access_control.hpp"

namespace ddssec::rtps::testing {

class LaxAccessControl : public spi::AccessControl {
 public:
  explicit LaxAccessControl(std::unique_ptr<spi::AccessControl> real) : real_(std::move(real)) {}

  Result<spi::PermissionsHandle> validate_local_permissions(spi::IdentityHandle identity,
                                                            DomainId domain_id,
                                                            const spi::PropertyList& properties,
                                                            std::string_view tag) override {
    return real_->validate_local_permissions(identity, domain_id, properties, tag);
  }
  Result<spi::PermissionsHandle> validate_remote_permissions(
      spi::IdentityHandle local_identity, spi::IdentityHandle remote_identity,
      const spi::Token& permissions_token, const spi::Token& credential) override {
    return real_->validate_remote_permissions(local_identity, remote_identity, permissions_token,
                                              credential);
  }
  Status check_create_participant(spi::PermissionsHandle local, DomainId domain_id) override {
    return real_->check_create_participant(local, domain_id);
  }
  Status check_create_datawriter(spi::PermissionsHandle, DomainId,
                                 const spi::EndpointRequest&) override {
    return {};
  }
  Status check_create_datareader(spi::PermissionsHandle, DomainId,
                                 const spi::EndpointRequest&) override {
    return {};
  }
  Status check_create_topic(spi::PermissionsHandle, DomainId, std::string_view) override {
    return {};
  }
  Status check_remote_participant(spi::PermissionsHandle remote, DomainId domain_id) override {
    return real_->check_remote_participant(remote, domain_id);
  }
  Status check_remote_datawriter(spi::PermissionsHandle remote, DomainId domain_id,
                                 const spi::EndpointRequest& request) override {
    return real_->check_remote_datawriter(remote, domain_id, request);
  }
  Result<RemoteDatareader> check_remote_datareader(spi::PermissionsHandle remote,
                                                   DomainId domain_id,
                                                   const spi::EndpointRequest& request) override {
    return real_->check_remote_datareader(remote, domain_id, request);
  }
  Status check_remote_match(spi::PermissionsHandle remote, const Match& match) override {
    return real_->check_remote_match(remote, match);
  }
  Status check_remote_topic(spi::PermissionsHandle remote, DomainId domain_id,
                            std::string_view topic_name) override {
    return real_->check_remote_topic(remote, domain_id, topic_name);
  }
  Result<spi::Token> permissions_token(spi::PermissionsHandle local) override {
    return real_->permissions_token(local);
  }
  Result<spi::Token> permissions_credential_token(spi::PermissionsHandle local) override {
    return real_->permissions_credential_token(local);
  }
  Result<spi::ParticipantSecurityAttributes> participant_sec_attributes(
      spi::PermissionsHandle local) override {
    return real_->participant_sec_attributes(local);
  }
  Result<spi::TopicSecurityAttributes> topic_sec_attributes(spi::PermissionsHandle local,
                                                            std::string_view topic_name) override {
    return real_->topic_sec_attributes(local, topic_name);
  }
  Result<spi::EndpointSecurityAttributes> datawriter_sec_attributes(
      spi::PermissionsHandle local, const spi::EndpointRequest& request) override {
    return real_->datawriter_sec_attributes(local, request);
  }
  Result<spi::EndpointSecurityAttributes> datareader_sec_attributes(
      spi::PermissionsHandle local, const spi::EndpointRequest& request) override {
    return real_->datareader_sec_attributes(local, request);
  }
  Result<spi::EndpointSecurityAttributes> unused_topic_attributes(
      spi::PermissionsHandle local, std::string_view topic_name) override {
    return real_->unused_topic_attributes(local, topic_name);
  }
  void forget_topic(spi::PermissionsHandle local, std::string_view topic_name) override {
    real_->forget_topic(local, topic_name);
  }
  Status return_permissions_handle(spi::PermissionsHandle permissions) override {
    return real_->return_permissions_handle(permissions);
  }
  std::optional<WallTime> next_expiry() override { return real_->next_expiry(); }
  std::vector<spi::PermissionsHandle> poll(spi::PermissionsHandle local) override {
    return real_->poll(local);
  }

 private:
  const std::unique_ptr<spi::AccessControl> real_;
};

}  // namespace ddssec::rtps::testing
