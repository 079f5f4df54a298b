// A participant with a valid certificate that breaks the rules: the three stock plugins, with a few
// of their functions replaced. INSIDER_TAMPER names what it does:
//   announce     its endpoints announce that nothing about them is access controlled
//   decoy        the same for its endpoint in the partition "Hidden"; the others are honest
//   participant  its participant's key tokens name the victim as their source
//   endpoint     its writers' key tokens name the victim as their source
//   source       its protected messages go on in the victim's name
//   key-only     its key tokens are sent as a key instead of data
//   key-hash     its key tokens have no payload, but a key hash
//   fragment     its key tokens are sent as the second fragment of a message that never ends
//   repeat       its builtin writers' key tokens come several times for two that are never matched
//   invent       its writers are announced, and send key tokens, as builtin ones that do not exist
//   nobody       its writers' key tokens have no GUID prefix
//   dispose      instead of announcing its writers, it says that the victim's are gone
//   speak-as     it announces its readers as the victim's, without access control
//   clear        its protected messages hold a liveliness message of its plain writer that says
//                that the victim is gone
//   smuggle      instead of announcements, the same after an empty submessage under the same key
//   type         its endpoints announce type information that ends a process that reads it
//   circle       its writers announce a type that needs another, its readers that other one, which
//                needs the first
//   many         its endpoints announce a type that needs hundreds of others
//   splice       it sends fragments of announcements from which the receiver's host makes one that
//                ends the victim's writer (splice.hpp)
//   splice-type  the same with type information that ends a process
//   partitions   its endpoints announce partition expressions that take hours to match, and that
//                nothing about them is access controlled
//   locators     its endpoints announce hundreds of locators
//   address      its endpoints announce an address in the form of RTPS 1, for which the host frees
//                memory that it never wrote
//   address-qos  its samples come with such an address in their inline QoS
//   requests     its volatile secure reader acknowledges nothing, and requests fragments of all key
//                tokens; it prints those for others on stderr (token_requests.hpp)
//   keys         it only prints the keys that it gets on stderr (../keys_test.py)
// INSIDER_VICTIM is the beginning of the victim's GUID, in hexadecimal digits. The insider reports
// on stderr what it did.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <string>
#include <utility>
#include <vector>

#include "plugins/cyclonedds/abi.hpp"
#include "tests/interop/insider/tampering.hpp"
#include "tests/interop/insider/token_requests.hpp"

namespace {

using namespace insider;
using Octets = DDS_Security_OctetSeq;
using Exception = DDS_Security_SecurityException;

// Returns the function of the stock library that ours replaces.
template <class Function>
Function* stock(const char* library, const char* name) {
  const auto path = std::string(DDSSEC_STOCK_PLUGIN_DIR "/") + library;
  void* const handle = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) std::fprintf(stderr, "insider: %s\n", dlerror());
  return handle == nullptr ? nullptr : reinterpret_cast<Function*>(dlsym(handle, name));
}
using Init = int(const char*, void**, ddsi_domaingv*);
using Finalize = int(void*);

// ---- authentication: which participant is the victim

decltype(dds_security_authentication::validate_local_identity) validate_local;
decltype(dds_security_authentication::validate_remote_identity) validate_remote;

DDS_Security_ValidationResult_t my_validate_local(
    dds_security_authentication* instance, DDS_Security_IdentityHandle* handle,
    DDS_Security_GUID_t* guid, const DDS_Security_DomainId domain, const DDS_Security_Qos* qos,
    const DDS_Security_GUID_t* candidate, Exception* ex) {
  const auto result = validate_local(instance, handle, guid, domain, qos, candidate, ex);
  if (result == DDS_SECURITY_VALIDATION_OK) {
    say_prefix("own", guid->prefix);
    std::memcpy(own_prefix, guid->prefix, sizeof own_prefix);
  }
  return result;
}

DDS_Security_ValidationResult_t my_validate_remote(
    dds_security_authentication* instance, DDS_Security_IdentityHandle* handle,
    DDS_Security_AuthRequestMessageToken* local_request,
    const DDS_Security_AuthRequestMessageToken* remote_request,
    const DDS_Security_IdentityHandle local, const DDS_Security_IdentityToken* token,
    const DDS_Security_GUID_t* guid, Exception* ex) {
  if (tampers("keys")) say_prefix("other", guid->prefix);
  const char* const begin = std::getenv("INSIDER_VICTIM");
  if (begin != nullptr && hex_of(guid->prefix).starts_with(begin)) victim.meet(guid->prefix);
  return validate_remote(instance, handle, local_request, remote_request, local, token, guid, ex);
}

// ---- access control: nothing is refused locally

DDS_Security_boolean allow_endpoint(dds_security_access_control*,
                                    const DDS_Security_PermissionsHandle,
                                    const DDS_Security_DomainId, const char*,
                                    const DDS_Security_Qos*, const DDS_Security_PartitionQosPolicy*,
                                    const DDS_Security_DataTags*, Exception*) {
  return 1;
}
DDS_Security_boolean allow_topic(dds_security_access_control*, const DDS_Security_PermissionsHandle,
                                 const DDS_Security_DomainId, const char*, const DDS_Security_Qos*,
                                 Exception*) {
  return 1;
}

// ---- cryptography: changes of messages before they are encrypted

decltype(dds_security_crypto_transform::encode_datawriter_submessage) encode_submessage;
decltype(dds_security_crypto_transform::encode_rtps_message) encode_message;

// Encodes all of them into one. `encode(&encoded, &plain)` encodes one.
template <class Encode>
DDS_Security_boolean encode_all(Octets* encoded, const std::vector<Bytes>& plains,
                                Encode&& encode) {
  Bytes all;
  for (auto plain : plains) {
    const auto size = static_cast<DDS_Security_unsigned_long>(plain.size());
    const Octets mine{size, size, plain.data()};
    Octets one{};
    if (!encode(&one, &mine)) return 0;
    all.insert(all.end(), one._buffer, one._buffer + one._length);
    std::free(one._buffer);
  }
  encoded->_buffer = static_cast<DDS_Security_octet*>(std::malloc(all.size()));
  std::memcpy(encoded->_buffer, all.data(), all.size());
  encoded->_length = encoded->_maximum = static_cast<DDS_Security_unsigned_long>(all.size());
  say_tampered();
  return 1;
}

DDS_Security_boolean encode_each(dds_security_crypto_transform* instance, Octets* encoded,
                                 const std::vector<Bytes>& plains,
                                 const DDS_Security_DatawriterCryptoHandle sender,
                                 const DDS_Security_DatareaderCryptoHandleSeq* receivers,
                                 DDS_Security_long* index, Exception* ex) {
  const auto count = static_cast<DDS_Security_long>(receivers->_length);
  return encode_all(encoded, plains, [&](Octets* one, const Octets* mine) {
    const Octets none{};
    for (*index = 0; *index < count;)
      if (!encode_submessage(instance, one, one->_buffer == nullptr ? mine : &none, sender,
                             receivers, index, ex))
        return false;
    return true;
  });
}

DDS_Security_boolean my_encode_submessage(dds_security_crypto_transform* instance, Octets* encoded,
                                          const Octets* plain,
                                          const DDS_Security_DatawriterCryptoHandle sender,
                                          const DDS_Security_DatareaderCryptoHandleSeq* receivers,
                                          DDS_Security_long* index, Exception* ex) {
  if (plain->_buffer == nullptr)
    return encode_submessage(instance, encoded, plain, sender, receivers, index, ex);
  Bytes octets(plain->_buffer, plain->_buffer + plain->_length);
  // Its announcements wait, and the readers request them again.
  const bool splices = tampers("splice") || tampers("splice-type");
  const bool needs_victim = tampers("dispose") || tampers("smuggle") || splices;
  if (is_of_writer(octets, 0xff0003c2) && needs_victim) {
    if (victim.prefix().empty()) return 0;
    if (splices)
      return encode_each(instance, encoded, spliced(octets), sender, receivers, index, ex);
  }
  tamper_with_submessage(octets);
  const auto size = static_cast<DDS_Security_unsigned_long>(octets.size());
  const Octets mine{size, size, octets.data()};
  return encode_submessage(instance, encoded, &mine, sender, receivers, index, ex);
}

DDS_Security_boolean my_encode_message(dds_security_crypto_transform* instance, Octets* encoded,
                                       const Octets* plain,
                                       const DDS_Security_ParticipantCryptoHandle sender,
                                       const DDS_Security_ParticipantCryptoHandleSeq* receivers,
                                       DDS_Security_long* index, Exception* ex) {
  const auto prefix = victim.prefix();
  const bool changes = tampers("source") || tampers("clear");
  if (plain->_buffer == nullptr || prefix.empty() || !changes)
    return encode_message(instance, encoded, plain, sender, receivers, index, ex);
  Bytes octets(plain->_buffer, plain->_buffer + plain->_length);
  tamper_with_message(octets, prefix);
  const auto size = static_cast<DDS_Security_unsigned_long>(octets.size());
  const Octets mine{size, size, octets.data()};
  return encode_message(instance, encoded, &mine, sender, receivers, index, ex);
}

decltype(dds_security_crypto_transform::encode_datareader_submessage) encode_reader_submessage;
decltype(dds_security_crypto_transform::decode_datawriter_submessage) decode_submessage;

DDS_Security_boolean my_encode_reader_submessage(
    dds_security_crypto_transform* instance, Octets* encoded, const Octets* plain,
    const DDS_Security_DatareaderCryptoHandle sender,
    const DDS_Security_DatawriterCryptoHandleSeq* receivers, Exception* ex) {
  const Bytes octets(plain->_buffer, plain->_buffer + plain->_length);
  if (!tampers("requests") || !token_requests::is_acknowledgment(octets))
    return encode_reader_submessage(instance, encoded, plain, sender, receivers, ex);
  return encode_all(encoded, token_requests::instead_of_acknowledgment(),
                    [&](Octets* one, const Octets* mine) {
                      return encode_reader_submessage(instance, one, mine, sender, receivers, ex);
                    });
}

DDS_Security_boolean my_decode_submessage(dds_security_crypto_transform* instance, Octets* plain,
                                          const Octets* encoded,
                                          const DDS_Security_DatareaderCryptoHandle receiver,
                                          const DDS_Security_DatawriterCryptoHandle sender,
                                          Exception* ex) {
  const auto done = decode_submessage(instance, plain, encoded, receiver, sender, ex);
  if (done && tampers("requests") &&
      token_requests::is_for_another(plain->_buffer, plain->_length, own_prefix))
    std::fprintf(stderr, "insider: got key tokens for another\n");
  return done;
}

// ---- key exchange: keys that it gets from others

using Exchange = dds_security_crypto_key_exchange;
decltype(Exchange::set_remote_datawriter_crypto_tokens) set_writer_tokens;

// Prints the material of the first token, with which its owner protects submessages.
void say_key(const DDS_Security_CryptoTokenSeq* tokens) {
  if (!tampers("keys") || tokens->_length == 0) return;
  const auto& properties = tokens->_buffer[0].binary_properties;
  if (properties._length == 0) return;
  const auto& value = properties._buffer[0].value;
  std::string hex;
  for (DDS_Security_unsigned_long i = 0; i < value._length; ++i) {
    char two[3];
    std::snprintf(two, sizeof two, "%02x", value._buffer[i]);
    hex += two;
  }
  std::fprintf(stderr, "insider: writer key %s\n", hex.c_str());
}

DDS_Security_boolean my_set_writer_tokens(Exchange* instance,
                                          const DDS_Security_DatareaderCryptoHandle local,
                                          const DDS_Security_DatawriterCryptoHandle remote,
                                          const DDS_Security_DatawriterCryptoTokenSeq* tokens,
                                          Exception* ex) {
  say_key(tokens);
  return set_writer_tokens(instance, local, remote, tokens, ex);
}

}  // namespace

DDSSEC_EXPORT int init_authentication(const char* argument, void** context, ddsi_domaingv* domain) {
  auto* const init = stock<Init>("libdds_security_auth.so", "init_authentication");
  if (init == nullptr || init(argument, context, domain) != 0) return 1;
  auto* const plugin = static_cast<dds_security_authentication*>(*context);
  validate_local = std::exchange(plugin->validate_local_identity, my_validate_local);
  validate_remote = std::exchange(plugin->validate_remote_identity, my_validate_remote);
  return 0;
}
DDSSEC_EXPORT int finalize_authentication(void* context) {
  return stock<Finalize>("libdds_security_auth.so", "finalize_authentication")(context);
}

DDSSEC_EXPORT int init_access_control(const char* argument, void** context, ddsi_domaingv* domain) {
  auto* const init = stock<Init>("libdds_security_ac.so", "init_access_control");
  if (init == nullptr || init(argument, context, domain) != 0) return 1;
  auto* const plugin = static_cast<dds_security_access_control*>(*context);
  plugin->check_create_datawriter = allow_endpoint;
  plugin->check_create_datareader = allow_endpoint;
  plugin->check_create_topic = allow_topic;
  return 0;
}
DDSSEC_EXPORT int finalize_access_control(void* context) {
  return stock<Finalize>("libdds_security_ac.so", "finalize_access_control")(context);
}

DDSSEC_EXPORT int init_crypto(const char* argument, void** context, ddsi_domaingv* domain) {
  auto* const init = stock<Init>("libdds_security_crypto.so", "init_crypto");
  if (init == nullptr || init(argument, context, domain) != 0) return 1;
  auto* const plugin = static_cast<dds_security_cryptography*>(*context);
  auto& transform = *plugin->crypto_transform;
  encode_submessage = std::exchange(transform.encode_datawriter_submessage, my_encode_submessage);
  encode_message = std::exchange(transform.encode_rtps_message, my_encode_message);
  encode_reader_submessage =
      std::exchange(transform.encode_datareader_submessage, my_encode_reader_submessage);
  decode_submessage = std::exchange(transform.decode_datawriter_submessage, my_decode_submessage);
  auto& exchange = *plugin->crypto_key_exchange;
  set_writer_tokens =
      std::exchange(exchange.set_remote_datawriter_crypto_tokens, my_set_writer_tokens);
  return 0;
}
DDSSEC_EXPORT int finalize_crypto(void* context) {
  return stock<Finalize>("libdds_security_crypto.so", "finalize_crypto")(context);
}
