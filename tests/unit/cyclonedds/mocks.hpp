// Plugins whose answers a test decides. Their constructors are in mocks.cpp, because compiling them
// takes long.
#pragma once

#include <gmock/gmock.h>

#include "plugins/spi/access_control.hpp"
#include "plugins/spi/authentication.hpp"
#include "plugins/spi/cryptography.hpp"

namespace ddssec::cyclonedds {

class MockAuthentication : public spi::Authentication {
 public:
  MockAuthentication();
  ~MockAuthentication() override;

  MOCK_METHOD(Result<LocalIdentity>, validate_local_identity,
              (DomainId, const spi::PropertyList&, const Guid&), (override));
  MOCK_METHOD(Result<spi::Token>, identity_token, (spi::IdentityHandle, spi::CipherMask),
              (override));
  MOCK_METHOD(Result<spi::Token>, identity_status_token, (spi::IdentityHandle), (override));
  MOCK_METHOD(Status, set_permissions_credential_and_token,
              (spi::IdentityHandle, const spi::Token&, const spi::Token&), (override));
  MOCK_METHOD(Result<RemoteIdentity>, validate_remote_identity,
              (spi::IdentityHandle, const std::optional<spi::Token>&, const spi::Token&,
               const Guid&),
              (override));
  MOCK_METHOD(Result<HandshakeStep>, begin_handshake_request,
              (spi::IdentityHandle, spi::IdentityHandle, BytesView), (override));
  MOCK_METHOD(Result<HandshakeStep>, begin_handshake_reply,
              (const spi::Token&, spi::IdentityHandle, spi::IdentityHandle, BytesView), (override));
  MOCK_METHOD(Result<HandshakeStep>, process_handshake, (spi::HandshakeHandle, const spi::Token&),
              (override));
  MOCK_METHOD(Outline, outline, (const spi::Token&), (const, override));
  MOCK_METHOD(Result<std::shared_ptr<const spi::SharedSecret>>, shared_secret,
              (spi::HandshakeHandle), (override));
  MOCK_METHOD(Result<spi::Token>, authenticated_peer_credential_token, (spi::HandshakeHandle),
              (override));
  MOCK_METHOD(Status, return_handshake_handle, (spi::HandshakeHandle), (override));
  MOCK_METHOD(Status, return_identity_handle, (spi::IdentityHandle), (override));
  MOCK_METHOD(std::optional<WallTime>, next_expiry, (), (override));
  MOCK_METHOD(std::vector<spi::IdentityHandle>, poll, (spi::IdentityHandle), (override));
};

class MockAccessControl : public spi::AccessControl {
 public:
  MockAccessControl();
  ~MockAccessControl() override;

  using Handle = spi::PermissionsHandle;
  MOCK_METHOD(Result<Handle>, validate_local_permissions,
              (spi::IdentityHandle, DomainId, const spi::PropertyList&, std::string_view),
              (override));
  MOCK_METHOD(Result<Handle>, validate_remote_permissions,
              (spi::IdentityHandle, spi::IdentityHandle, const spi::Token&, const spi::Token&),
              (override));
  MOCK_METHOD(Status, check_create_participant, (Handle, DomainId), (override));
  MOCK_METHOD(Status, check_create_datawriter, (Handle, DomainId, const spi::EndpointRequest&),
              (override));
  MOCK_METHOD(Status, check_create_datareader, (Handle, DomainId, const spi::EndpointRequest&),
              (override));
  MOCK_METHOD(Status, check_create_topic, (Handle, DomainId, std::string_view), (override));
  MOCK_METHOD(Status, check_remote_participant, (Handle, DomainId), (override));
  MOCK_METHOD(Status, check_remote_datawriter, (Handle, DomainId, const spi::EndpointRequest&),
              (override));
  MOCK_METHOD(Result<RemoteDatareader>, check_remote_datareader,
              (Handle, DomainId, const spi::EndpointRequest&), (override));
  MOCK_METHOD(Status, check_remote_match, (Handle, const Match&), (override));
  MOCK_METHOD(Status, check_remote_topic, (Handle, DomainId, std::string_view), (override));
  MOCK_METHOD(Result<spi::Token>, permissions_token, (Handle), (override));
  MOCK_METHOD(std::uint64_t, renewals, (spi::PermissionsHandle), (override));
  MOCK_METHOD(Status, check_own_endpoint, (Handle, bool, const spi::EndpointRequest&), (override));
  MOCK_METHOD(std::optional<std::size_t>, find_unknown_right,
              (Handle, std::span<const OwnEndpoint>), (override));
  MOCK_METHOD(Result<spi::Token>, permissions_credential_token, (Handle), (override));
  MOCK_METHOD(Result<spi::ParticipantSecurityAttributes>, participant_sec_attributes, (Handle),
              (override));
  MOCK_METHOD(Result<spi::TopicSecurityAttributes>, topic_sec_attributes,
              (Handle, std::string_view), (override));
  MOCK_METHOD(Result<spi::EndpointSecurityAttributes>, datawriter_sec_attributes,
              (Handle, const spi::EndpointRequest&), (override));
  MOCK_METHOD(Result<spi::EndpointSecurityAttributes>, datareader_sec_attributes,
              (Handle, const spi::EndpointRequest&), (override));
  MOCK_METHOD(Result<spi::EndpointSecurityAttributes>, unused_topic_attributes,
              (Handle, std::string_view), (override));
  MOCK_METHOD(void, forget_topic, (Handle, std::string_view), (override));
  MOCK_METHOD(Status, return_permissions_handle, (Handle), (override));
  MOCK_METHOD(std::optional<WallTime>, next_expiry, (), (override));
  MOCK_METHOD(std::vector<Handle>, poll, (Handle), (override));
};

class MockCryptography : public spi::Cryptography,
                         public spi::CryptoKeyFactory,
                         public spi::CryptoKeyExchange,
                         public spi::CryptoTransform {
 public:
  MockCryptography();
  ~MockCryptography() override;

  using Participant = spi::ParticipantCryptoHandle;
  using Datawriter = spi::DatawriterCryptoHandle;
  using Datareader = spi::DatareaderCryptoHandle;
  using Tokens = std::vector<spi::Token>;

  spi::CryptoKeyFactory& key_factory() override { return *this; }
  spi::CryptoKeyExchange& key_exchange() override { return *this; }
  spi::CryptoTransform& transform() override { return *this; }

  MOCK_METHOD(Result<Participant>, register_local_participant,
              (spi::IdentityHandle, spi::PermissionsHandle, const spi::PropertyList&,
               const spi::ParticipantSecurityAttributes&),
              (override));
  MOCK_METHOD(Result<Participant>, register_matched_remote_participant,
              (Participant, spi::IdentityHandle, spi::PermissionsHandle, const spi::SharedSecret&),
              (override));
  MOCK_METHOD(Result<Datawriter>, register_local_datawriter,
              (Participant, const spi::PropertyList&, const spi::EndpointSecurityAttributes&),
              (override));
  MOCK_METHOD(Result<Datareader>, register_matched_remote_datareader,
              (Datawriter, Participant, const spi::SharedSecret&, bool), (override));
  MOCK_METHOD(Result<Datareader>, register_local_datareader,
              (Participant, const spi::PropertyList&, const spi::EndpointSecurityAttributes&),
              (override));
  MOCK_METHOD(Result<Datawriter>, register_matched_remote_datawriter,
              (Datareader, Participant, const spi::SharedSecret&), (override));
  MOCK_METHOD(spi::CipherMask, supported_ciphers, (), (const, override));
  MOCK_METHOD(Result<spi::SymmetricCipherInfo>, cipher_info, (Participant), (override));
  MOCK_METHOD(Result<spi::CipherMask>, required_ciphers, (Datawriter), (override));
  MOCK_METHOD(Result<spi::CipherMask>, required_ciphers, (Datareader), (override));
  MOCK_METHOD(Result<std::unique_ptr<spi::PreSharedKeys>>, pre_shared_keys,
              (const spi::PreSharedKeyRequest&), (override));
  MOCK_METHOD(Result<spi::KeyRevision>, revise_local_entity_keys, (Participant), (override));
  MOCK_METHOD(Status, activate_key_revision, (Participant, spi::KeyRevision), (override));
  MOCK_METHOD(bool, is_key_revision_due, (Participant), (const, override));
  MOCK_METHOD(void, forget_former_keys, (), (override));
  MOCK_METHOD(bool, poll_stranded_keys, (spi::IdentityHandle), (override));
  MOCK_METHOD(void, cut_off, (Participant), (override));
  MOCK_METHOD(Status, unregister_participant, (Participant), (override));
  MOCK_METHOD(Status, unregister_datawriter, (Datawriter), (override));
  MOCK_METHOD(Status, unregister_datareader, (Datareader), (override));

  MOCK_METHOD(Result<Tokens>, create_local_participant_crypto_tokens,
              (Participant, Participant, spi::KeyStage), (override));
  MOCK_METHOD(Status, set_remote_participant_crypto_tokens,
              (Participant, Participant, std::span<const spi::Token>), (override));
  MOCK_METHOD(Result<Tokens>, create_local_datawriter_crypto_tokens,
              (Datawriter, Datareader, spi::KeyStage), (override));
  MOCK_METHOD(Status, set_remote_datawriter_crypto_tokens,
              (Datareader, Datawriter, std::span<const spi::Token>), (override));
  MOCK_METHOD(Result<Tokens>, create_local_datareader_crypto_tokens,
              (Datareader, Datawriter, spi::KeyStage), (override));
  MOCK_METHOD(Status, set_remote_datareader_crypto_tokens,
              (Datawriter, Datareader, std::span<const spi::Token>), (override));
  MOCK_METHOD(Sha256Digest, digest_of, (std::span<const spi::Token>), (const, override));
  MOCK_METHOD(spi::KeyRevision, key_revision_of, (std::span<const spi::Token>), (const, override));

  using Size = Result<std::size_t>;
  MOCK_METHOD(Size, encode_serialized_payload, (Datawriter, BytesView, MutableBytes), (override));
  MOCK_METHOD(Size, encode_datawriter_submessage,
              (Datawriter, std::span<const Datareader>, BytesView, MutableBytes), (override));
  MOCK_METHOD(Size, encode_datareader_submessage,
              (Datareader, std::span<const Datawriter>, BytesView, MutableBytes), (override));
  MOCK_METHOD(Size, encode_rtps_message,
              (Participant, std::span<const Participant>, BytesView, MutableBytes), (override));
  MOCK_METHOD(Size, decode_rtps_message, (Participant, Participant, BytesView, MutableBytes),
              (override));
  MOCK_METHOD(Result<spi::SecureSubmessage>, preprocess_secure_submessage,
              (Participant, Participant, BytesView), (override));
  MOCK_METHOD(Size, decode_datawriter_submessage, (Datareader, Datawriter, BytesView, MutableBytes),
              (override));
  MOCK_METHOD(Size, decode_datareader_submessage, (Datawriter, Datareader, BytesView, MutableBytes),
              (override));
  MOCK_METHOD(Size, decode_serialized_payload, (Datareader, Datawriter, BytesView, MutableBytes),
              (override));
};

}  // namespace ddssec::cyclonedds

extern template class testing::NiceMock<ddssec::cyclonedds::MockAuthentication>;
extern template class testing::NiceMock<ddssec::cyclonedds::MockAccessControl>;
extern template class testing::NiceMock<ddssec::cyclonedds::MockCryptography>;
