// CryptoKeyFactory: registration of participants and endpoints.
#include <algorithm>
#include <utility>

#include "plugins/cyclonedds/access_control_gate.hpp"
#include "plugins/cyclonedds/cryptography_adapter.hpp"
#include "plugins/cyclonedds/peers_with_keys.hpp"
#include "plugins/cyclonedds/plugins_in_use.hpp"
#include "plugins/cyclonedds/session_resets.hpp"
#include "plugins/cyclonedds/token_translation.hpp"
#include "plugins/cyclonedds/value_translation.hpp"
#include "plugins/spi/process_properties.hpp"

namespace ddssec::cyclonedds {
namespace {

using Adapter = CryptographyAdapter;
using Instance = dds_security_crypto_key_factory;
using CHandle = DDS_Security_CryptoHandle;

Result<spi::PropertyList> optional_properties(const DDS_Security_PropertySeq* properties) {
  if (properties == nullptr) return spi::PropertyList{};
  return properties_from(*properties);
}

Result<spi::EndpointSecurityAttributes> gated_attributes_from(
    const DDS_Security_EndpointSecurityAttributes& attributes) {
  auto out = attributes_from(attributes);
  DDSSEC_ASSIGN_OR_RETURN(out.gate, AccessControlGate::of(attributes.ac_endpoint_properties));
  return out;
}

CHandle register_local_participant(Instance* instance, const DDS_Security_IdentityHandle identity,
                                   const DDS_Security_PermissionsHandle permissions,
                                   const DDS_Security_PropertySeq* properties,
                                   const DDS_Security_ParticipantSecurityAttributes* attributes,
                                   Exception* ex) {
  return ask_handle<Adapter>(
      instance, ex, [&](Adapter& adapter) -> Result<spi::ParticipantCryptoHandle> {
        DDSSEC_RETURN_IF_ERROR(require(attributes));
        report_plugins_in_use(adapter.host(), PluginKind::cryptography);
        DDSSEC_ASSIGN_OR_RETURN(auto property_list, optional_properties(properties));
        DDSSEC_ASSIGN_OR_RETURN(const auto list,
                                spi::with_process_properties(std::move(property_list)));
        DDSSEC_ASSIGN_OR_RETURN(const auto local,
                                adapter.key_factory().register_local_participant(
                                    {identity}, {permissions}, list, attributes_from(*attributes)));
        adapter.note_local(local, {identity});
        PeersWithKeys::of_process().add_local(local, {identity});
        return local;
      });
}

CHandle register_matched_remote_participant(Instance* instance, const CHandle local,
                                            const DDS_Security_IdentityHandle remote_identity,
                                            const DDS_Security_PermissionsHandle permissions,
                                            const DDS_Security_SharedSecretHandle secret_handle,
                                            Exception* ex) {
  return ask_handle<Adapter>(
      instance, ex, [&](Adapter& adapter) -> Result<spi::ParticipantCryptoHandle> {
        DDSSEC_ASSIGN_OR_RETURN(const auto secret, shared_secret_from(secret_handle));
        DDSSEC_ASSIGN_OR_RETURN(const auto peer,
                                adapter.key_factory().register_matched_remote_participant(
                                    {local}, {remote_identity}, {permissions}, secret));
        // Another product may match fewer endpoints, and would not notice that the session is
        // restarted.
        const bool is_ours = (secret.peer_ciphers & spi::kChaCha20Poly1305Bit) != 0;
        PeersWithKeys::of_process().note_discovered(peer, {remote_identity}, {local},
                                                    is_ours ? secret.peer_builtin_endpoints : 0);
        if (secret.peer_prefix)
          SessionResets::of_process().expect({peer, {local}}, {remote_identity},
                                             spi::derive_reset_token(secret, *secret.peer_prefix));
        return peer;
      });
}

CHandle register_local_datawriter(Instance* instance, const CHandle participant,
                                  const DDS_Security_PropertySeq* properties,
                                  const DDS_Security_EndpointSecurityAttributes* attributes,
                                  Exception* ex) {
  return ask_handle<Adapter>(
      instance, ex, [&](Adapter& adapter) -> Result<spi::DatawriterCryptoHandle> {
        DDSSEC_RETURN_IF_ERROR(require(attributes));
        DDSSEC_ASSIGN_OR_RETURN(const auto list, optional_properties(properties));
        DDSSEC_ASSIGN_OR_RETURN(const auto gated, gated_attributes_from(*attributes));
        DDSSEC_ASSIGN_OR_RETURN(const auto writer, adapter.key_factory().register_local_datawriter(
                                                       {participant}, list, gated));
        if (gated.is_builtin) PeersWithKeys::of_process().add_builtin(writer.value, {participant});
        return writer;
      });
}

CHandle register_matched_remote_datareader(Instance* instance, const CHandle local_datawriter,
                                           const CHandle remote_participant,
                                           const DDS_Security_SharedSecretHandle secret_handle,
                                           const DDS_Security_boolean is_relay_only,
                                           Exception* ex) {
  return ask_handle<Adapter>(
      instance, ex, [&](Adapter& adapter) -> Result<spi::DatareaderCryptoHandle> {
        DDSSEC_ASSIGN_OR_RETURN(const auto secret, shared_secret_from(secret_handle));
        DDSSEC_ASSIGN_OR_RETURN(
            const auto reader,
            adapter.key_factory().register_matched_remote_datareader(
                {local_datawriter}, {remote_participant}, secret, is_relay_only != 0));
        PeersWithKeys::of_process().note_matched(reader.value, {remote_participant},
                                                 local_datawriter);
        return reader;
      });
}

CHandle register_local_datareader(Instance* instance, const CHandle participant,
                                  const DDS_Security_PropertySeq* properties,
                                  const DDS_Security_EndpointSecurityAttributes* attributes,
                                  Exception* ex) {
  return ask_handle<Adapter>(
      instance, ex, [&](Adapter& adapter) -> Result<spi::DatareaderCryptoHandle> {
        DDSSEC_RETURN_IF_ERROR(require(attributes));
        DDSSEC_ASSIGN_OR_RETURN(const auto list, optional_properties(properties));
        DDSSEC_ASSIGN_OR_RETURN(const auto gated, gated_attributes_from(*attributes));
        DDSSEC_ASSIGN_OR_RETURN(const auto reader, adapter.key_factory().register_local_datareader(
                                                       {participant}, list, gated));
        if (gated.is_builtin) PeersWithKeys::of_process().add_builtin(reader.value, {participant});
        return reader;
      });
}

CHandle register_matched_remote_datawriter(Instance* instance, const CHandle local_datareader,
                                           const CHandle remote_participant,
                                           const DDS_Security_SharedSecretHandle secret_handle,
                                           Exception* ex) {
  return ask_handle<Adapter>(
      instance, ex, [&](Adapter& adapter) -> Result<spi::DatawriterCryptoHandle> {
        DDSSEC_ASSIGN_OR_RETURN(const auto secret, shared_secret_from(secret_handle));
        DDSSEC_ASSIGN_OR_RETURN(const auto writer,
                                adapter.key_factory().register_matched_remote_datawriter(
                                    {local_datareader}, {remote_participant}, secret));
        PeersWithKeys::of_process().note_matched(writer.value, {remote_participant},
                                                 local_datareader);
        return writer;
      });
}

// The core returns some handles twice when several participants end at the same time. The second
// time nothing is left to do.
Status unless_gone(Status status) {
  if (status || status.error().code() != Code::crypto_handle_unknown) return status;
  return {};
}

// Endpoints without protection were never registered, and the host's handle for them is nil.
DDS_Security_boolean unregister_participant(Instance* instance, const CHandle handle,
                                            Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    if (handle == DDS_SECURITY_HANDLE_NIL) return {};
    PeersWithKeys::of_process().note_left({handle});
    SessionResets::of_process().forget({handle});
    adapter.forget_local({handle});
    return unless_gone(adapter.key_factory().unregister_participant({handle}));
  });
}

DDS_Security_boolean unregister_datawriter(Instance* instance, const CHandle handle,
                                           Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    if (handle == DDS_SECURITY_HANDLE_NIL) return {};
    PeersWithKeys::of_process().forget(handle);
    return unless_gone(adapter.key_factory().unregister_datawriter({handle}));
  });
}

DDS_Security_boolean unregister_datareader(Instance* instance, const CHandle handle,
                                           Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    if (handle == DDS_SECURITY_HANDLE_NIL) return {};
    PeersWithKeys::of_process().forget(handle);
    return unless_gone(adapter.key_factory().unregister_datareader({handle}));
  });
}

}  // namespace

const dds_security_crypto_key_factory kKeyFactoryFunctions = {
    .register_local_participant = register_local_participant,
    .register_matched_remote_participant = register_matched_remote_participant,
    .register_local_datawriter = register_local_datawriter,
    .register_matched_remote_datareader = register_matched_remote_datareader,
    .register_local_datareader = register_local_datareader,
    .register_matched_remote_datawriter = register_matched_remote_datawriter,
    .unregister_participant = unregister_participant,
    .unregister_datawriter = unregister_datawriter,
    .unregister_datareader = unregister_datareader,
};

}  // namespace ddssec::cyclonedds
