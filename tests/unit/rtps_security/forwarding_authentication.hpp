// The plugins' authentication, wrapped so that a test can watch or change what it returns.
#pragma once

#include <memory>

#include "plugins/spi/authentication.hpp"

namespace ddssec::rtps::testing {

class ForwardingAuthentication : public spi::Authentication {
 public:
  explicit ForwardingAuthentication(std::unique_ptr<spi::Authentication> real)
      : real_(std::move(real)) {}

  Result<LocalIdentity> validate_local_identity(DomainId domain,
                                                const spi::PropertyList& properties,
                                                const Guid& candidate) override {
    return real_->validate_local_identity(domain, properties, candidate);
  }
  Result<spi::Token> identity_token(spi::IdentityHandle local, spi::CipherMask ciphers) override {
    return real_->identity_token(local, ciphers);
  }
  Result<spi::Token> identity_status_token(spi::IdentityHandle local) override {
    return real_->identity_status_token(local);
  }
  Status set_permissions_credential_and_token(spi::IdentityHandle local,
                                              const spi::Token& credential,
                                              const spi::Token& token) override {
    return real_->set_permissions_credential_and_token(local, credential, token);
  }
  Result<RemoteIdentity> validate_remote_identity(spi::IdentityHandle local,
                                                  const std::optional<spi::Token>& request,
                                                  const spi::Token& token,
                                                  const Guid& remote) override {
    return real_->validate_remote_identity(local, request, token, remote);
  }
  Result<HandshakeStep> begin_handshake_request(spi::IdentityHandle initiator,
                                                spi::IdentityHandle replier,
                                                BytesView data) override {
    return real_->begin_handshake_request(initiator, replier, data);
  }
  Result<HandshakeStep> begin_handshake_reply(const spi::Token& request,
                                              spi::IdentityHandle initiator,
                                              spi::IdentityHandle replier,
                                              BytesView data) override {
    return real_->begin_handshake_reply(request, initiator, replier, data);
  }
  Result<HandshakeStep> process_handshake(spi::HandshakeHandle handshake,
                                          const spi::Token& message) override {
    return real_->process_handshake(handshake, message);
  }
  Outline outline(const spi::Token& message) const override { return real_->outline(message); }
  Result<std::shared_ptr<const spi::SharedSecret>> shared_secret(
      spi::HandshakeHandle handshake) override {
    return real_->shared_secret(handshake);
  }
  Result<spi::Token> authenticated_peer_credential_token(spi::HandshakeHandle handshake) override {
    return real_->authenticated_peer_credential_token(handshake);
  }
  std::string authenticated_subject(spi::HandshakeHandle handshake) override {
    return real_->authenticated_subject(handshake);
  }
  Result<std::optional<spi::OfferedRenewal>> offer_renewal(
      spi::HandshakeHandle handshake) override {
    return real_->offer_renewal(handshake);
  }
  Result<spi::Token> judge_renewal(spi::HandshakeHandle handshake,
                                   const spi::Token& offer) override {
    return real_->judge_renewal(handshake, offer);
  }
  Result<spi::Token> accept_renewal(spi::HandshakeHandle handshake,
                                    const spi::Token& offer) override {
    return real_->accept_renewal(handshake, offer);
  }
  Result<spi::SessionFacts> note_renewal_accepted(spi::HandshakeHandle handshake,
                                                  const spi::Token& answer) override {
    return real_->note_renewal_accepted(handshake, answer);
  }
  Status return_handshake_handle(spi::HandshakeHandle handshake) override {
    return real_->return_handshake_handle(handshake);
  }
  Status return_identity_handle(spi::IdentityHandle identity) override {
    return real_->return_identity_handle(identity);
  }
  std::optional<WallTime> next_expiry() override { return real_->next_expiry(); }
  std::vector<spi::IdentityHandle> poll(spi::IdentityHandle local) override {
    return real_->poll(local);
  }

 private:
  std::unique_ptr<spi::Authentication> real_;
};

}  // namespace ddssec::rtps::testing
