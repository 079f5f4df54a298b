// CryptoKeyExchange: creates and accepts crypto tokens.
#include <algorithm>
#include <array>
#include <utility>

#include "plugins/cyclonedds/cryptography_adapter.hpp"
#include "plugins/cyclonedds/peers_with_keys.hpp"
#include "plugins/cyclonedds/token_translation.hpp"

namespace ddssec::cyclonedds {
namespace {

using Adapter = CryptographyAdapter;
using Instance = dds_security_crypto_key_exchange;
using CHandle = DDS_Security_CryptoHandle;
using CTokens = DDS_Security_CryptoTokenSeq;

// Calls `create(key_exchange) -> Result<vector<Token>>`; an empty sequence means that nothing is
// sent.
template <class F>
DDS_Security_boolean create(Instance* instance, CTokens* out, Exception* ex, F&& create) noexcept {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_RETURN_IF_ERROR(require(out));
    *out = {};
    DDSSEC_ASSIGN_OR_RETURN(auto created, create(adapter.key_exchange()));
    const CryptoTokens tokens(std::move(created));
    return copy_tokens(tokens.view(), *out);
  });
}

// Calls `set(key_exchange, tokens) -> Status`; the host's tokens live only during the call.
template <class F>
DDS_Security_boolean set(Instance* instance, const CTokens* in, Exception* ex, F&& set) noexcept {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_ASSIGN_OR_RETURN(const auto tokens, CryptoTokens::from(in));
    return set(adapter.key_exchange(), tokens.view());
  });
}

Status set_participant_tokens(spi::CryptoKeyExchange& exchange, spi::ParticipantCryptoHandle local,
                              spi::ParticipantCryptoHandle remote, const CTokens& in) {
  DDSSEC_ASSIGN_OR_RETURN(const auto tokens, CryptoTokens::from(&in));
  return exchange.set_remote_participant_crypto_tokens(local, remote, tokens.view());
}

// True if the error is about the tokens, and not about the host's call.
bool is_about_tokens(Code code) {
  constexpr std::array kAboutHandles = {Code::crypto_handle_nil, Code::crypto_handle_unknown,
                                        Code::crypto_handle_wrong_kind, Code::crypto_not_matched};
  return std::ranges::find(kAboutHandles, code) == kAboutHandles.end();
}

DDS_Security_boolean create_local_participant_crypto_tokens(Instance* instance, CTokens* out,
                                                            const CHandle local,
                                                            const CHandle remote, Exception* ex) {
  return create(instance, out, ex, [&](spi::CryptoKeyExchange& exchange) {
    return exchange.create_local_participant_crypto_tokens({local}, {remote});
  });
}

DDS_Security_boolean set_remote_participant_crypto_tokens(Instance* instance, const CHandle local,
                                                          const CHandle remote, const CTokens* in,
                                                          Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_RETURN_IF_ERROR(require(in));
    const auto events = Host::raised_by_this_thread();
    const auto status = set_participant_tokens(adapter.key_exchange(), {local}, {remote}, *in);
    if (status) PeersWithKeys::of_process().note_keys_sent({remote}, {local});
    if (status || !is_about_tokens(status.error().code())) return status;
    // Refused tokens have no effect, so this reports success. If it reported an error, Cyclone DDS
    // would log each refused token of a participant and free none: a peer could fill log and
    // memory.
    if (Host::raised_by_this_thread() == events)
      adapter.host().refused(status.error(), info(status.error().code()).severity);
    return {};
  });
}

DDS_Security_boolean create_local_datawriter_crypto_tokens(Instance* instance, CTokens* out,
                                                           const CHandle local,
                                                           const CHandle remote, Exception* ex) {
  return create(instance, out, ex, [&](spi::CryptoKeyExchange& exchange) {
    return exchange.create_local_datawriter_crypto_tokens({local}, {remote});
  });
}

DDS_Security_boolean set_remote_datawriter_crypto_tokens(Instance* instance, const CHandle local,
                                                         const CHandle remote, const CTokens* in,
                                                         Exception* ex) {
  return set(instance, in, ex, [&](spi::CryptoKeyExchange& exchange, auto tokens) {
    return exchange.set_remote_datawriter_crypto_tokens({local}, {remote}, tokens);
  });
}

DDS_Security_boolean create_local_datareader_crypto_tokens(Instance* instance, CTokens* out,
                                                           const CHandle local,
                                                           const CHandle remote, Exception* ex) {
  return create(instance, out, ex, [&](spi::CryptoKeyExchange& exchange) {
    return exchange.create_local_datareader_crypto_tokens({local}, {remote});
  });
}

DDS_Security_boolean set_remote_datareader_crypto_tokens(Instance* instance, const CHandle local,
                                                         const CHandle remote, const CTokens* in,
                                                         Exception* ex) {
  return set(instance, in, ex, [&](spi::CryptoKeyExchange& exchange, auto tokens) {
    return exchange.set_remote_datareader_crypto_tokens({local}, {remote}, tokens);
  });
}

DDS_Security_boolean return_crypto_tokens(Instance* instance, CTokens* tokens, Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter&) -> Status {
    if (tokens != nullptr) free_tokens(*tokens);
    return {};
  });
}

}  // namespace

const dds_security_crypto_key_exchange kKeyExchangeFunctions = {
    .create_local_participant_crypto_tokens = create_local_participant_crypto_tokens,
    .set_remote_participant_crypto_tokens = set_remote_participant_crypto_tokens,
    .create_local_datawriter_crypto_tokens = create_local_datawriter_crypto_tokens,
    .set_remote_datawriter_crypto_tokens = set_remote_datawriter_crypto_tokens,
    .create_local_datareader_crypto_tokens = create_local_datareader_crypto_tokens,
    .set_remote_datareader_crypto_tokens = set_remote_datareader_crypto_tokens,
    .return_crypto_tokens = return_crypto_tokens,
};

}  // namespace ddssec::cyclonedds
