#include "tests/support/cyclone_driver.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>

namespace ddssec::driver {
namespace {

// Returns a domain of zeros. The stock plugins look into it for an event queue, which they leave
// alone until a listener is set; nothing else is read from it.
ddsi_domaingv* empty_domain() {
  alignas(64) static std::array<unsigned char, 1 << 16> zeros{};
  return reinterpret_cast<ddsi_domaingv*>(zeros.data());
}

// The flags with which Cyclone loads plugins. The leak sanitizer needs the stock plugins to stay
// loaded as ours do, to see what their statics hold.
#if defined(__SANITIZE_ADDRESS__)
constexpr int kLoadFlags = RTLD_NOW | RTLD_GLOBAL | RTLD_NODELETE;
#else
constexpr int kLoadFlags = RTLD_NOW | RTLD_GLOBAL;
#endif

template <class Properties>
void free_names(Properties& properties) {
  for (std::uint32_t i = 0; i < properties._length; ++i) std::free(properties._buffer[i].name);
}

}  // namespace

Refused::Refused(const std::string& call, const Exception& ex)
    : std::runtime_error(call + ": " + (ex.message != nullptr ? ex.message : "(no message)") +
                         " (" + std::to_string(ex.code) + ")"),
      code(ex.code) {}

Call::~Call() { std::free(ex_.message); }

Library::Library(const std::string& path, const std::string& init, const std::string& finalize)
    : handle_(dlopen(path.c_str(), kLoadFlags)) {
  if (handle_ == nullptr) throw std::runtime_error(dlerror());
  const auto init_function = reinterpret_cast<Init>(dlsym(handle_, init.c_str()));
  finalize_ = reinterpret_cast<Finalize>(dlsym(handle_, finalize.c_str()));
  if (init_function == nullptr || finalize_ == nullptr)
    throw std::runtime_error(path + " lacks " + init + " or " + finalize);
  if (init_function("", &context_, empty_domain()) != 0 || context_ == nullptr)
    throw std::runtime_error(init + " failed");
}

Library::~Library() {
  finalize_(context_);
  dlclose(handle_);
}

Domain::Domain(const Paths& paths)
    : authentication_(std::make_unique<Library>(paths.authentication, "init_authentication",
                                                "finalize_authentication")),
      access_control_(std::make_unique<Library>(paths.access_control, "init_access_control",
                                                "finalize_access_control")),
      cryptography_(
          std::make_unique<Library>(paths.cryptography, "init_crypto", "finalize_crypto")) {}

Domain::~Domain() {
  authentication_.reset();
  cryptography_.reset();
  access_control_.reset();
}

dds_security_authentication& Domain::authentication() {
  return *static_cast<dds_security_authentication*>(authentication_->context());
}
dds_security_access_control& Domain::access_control() {
  return *static_cast<dds_security_access_control*>(access_control_->context());
}
dds_security_cryptography& Domain::cryptography() {
  return *static_cast<dds_security_cryptography*>(cryptography_->context());
}

Token::~Token() {
  std::free(class_id);
  free_names(properties);
  for (std::uint32_t i = 0; i < properties._length; ++i) std::free(properties._buffer[i].value);
  std::free(properties._buffer);
  free_names(binary_properties);
  for (std::uint32_t i = 0; i < binary_properties._length; ++i) {
    auto& value = binary_properties._buffer[i].value;
    std::memset(value._buffer, 0, value._length);  // the core does the same
    std::free(value._buffer);
  }
  std::free(binary_properties._buffer);
}

Block::~Block() { std::free(_buffer); }
Block::Block(Block&& other) noexcept : DDS_Security_OctetSeq(other) {
  static_cast<DDS_Security_OctetSeq&>(other) = {};
}

DDS_Security_OctetSeq view(const Octets& octets) {
  const auto length = static_cast<std::uint32_t>(octets.size());
  return {length, length, const_cast<std::uint8_t*>(octets.data())};
}

namespace {

// Encodes in the loop over receivers that Cyclone has.
template <class Encode>
Block encode_in_loop(const std::vector<DDS_Security_CryptoHandle>& handles, const Octets& plain,
                     Encode&& encode) {
  const auto count = static_cast<std::uint32_t>(handles.size());
  const DDS_Security_LongLongSeq list{count, count,
                                      const_cast<DDS_Security_long_long*>(handles.data())};
  Block out;
  auto in = view(plain);
  for (DDS_Security_long index = 0; index < static_cast<DDS_Security_long>(count);) {
    Call call("encode");
    call.check(encode(&out, &in, &list, &index, call));
    in = {};
  }
  return out;
}

}  // namespace

Block Sender::encode_payload(const Octets& plain) const {
  Block out;
  DDS_Security_OctetSeq inline_qos{};
  const auto in = view(plain);
  auto* transform = plugin->crypto_transform;
  Call call("encode_serialized_payload");
  call.check(transform->encode_serialized_payload(transform, &out, &inline_qos, &in, writer, call));
  return out;
}

Block Sender::encode_submessage(const Octets& plain) const {
  auto* transform = plugin->crypto_transform;
  return encode_in_loop(
      remote_readers, plain, [&](auto* out, auto* in, auto* list, auto* index, Exception* ex) {
        return transform->encode_datawriter_submessage(transform, out, in, writer, list, index, ex);
      });
}

Block Sender::encode_message(const Octets& plain) const {
  auto* transform = plugin->crypto_transform;
  return encode_in_loop(
      remote_participants, plain, [&](auto* out, auto* in, auto* list, auto* index, Exception* ex) {
        return transform->encode_rtps_message(transform, out, in, participant, list, index, ex);
      });
}

Block Receiver::decode_payload(const DDS_Security_OctetSeq& encoded) const {
  Block out;
  const DDS_Security_OctetSeq inline_qos{};
  auto* transform = plugin->crypto_transform;
  Call call("decode_serialized_payload");
  call.check(transform->decode_serialized_payload(transform, &out, &encoded, &inline_qos, reader,
                                                  remote_writer, call));
  return out;
}

Block Receiver::decode_submessage(const DDS_Security_OctetSeq& encoded) const {
  auto* transform = plugin->crypto_transform;
  DDS_Security_DatawriterCryptoHandle from = 0;
  DDS_Security_DatareaderCryptoHandle to = 0;
  auto category = DDS_SECURITY_INFO_SUBMESSAGE;
  Call preprocess("preprocess_secure_submsg");
  preprocess.check(transform->preprocess_secure_submsg(
      transform, &from, &to, &category, &encoded, participant, remote_participant, preprocess));
  Block out;
  Call call("decode_datawriter_submessage");
  call.check(category == DDS_SECURITY_DATAWRITER_SUBMESSAGE &&
             transform->decode_datawriter_submessage(transform, &out, &encoded, to, from, call));
  return out;
}

Block Receiver::decode_message(const DDS_Security_OctetSeq& encoded) const {
  Block out;
  auto* transform = plugin->crypto_transform;
  Call call("decode_rtps_message");
  call.check(transform->decode_rtps_message(transform, &out, &encoded, participant,
                                            remote_participant, call));
  return out;
}

void to_machine_order(DDS_Security_OctetSeq& message) {
  if constexpr (std::endian::native == std::endian::big) return;
  for (std::uint32_t word = 8; word < 20 && message._length >= 20; word += 4)
    std::reverse(message._buffer + word, message._buffer + word + 4);
}

MadeUpSecret::MadeUpSecret(std::uint8_t seed) : secret(32, seed), layout{} {
  layout.shared_secret = secret.data();
  layout.shared_secret_size = 32;
  std::ranges::fill(layout.challenge1, static_cast<std::uint8_t>(seed + 1));
  std::ranges::fill(layout.challenge2, static_cast<std::uint8_t>(seed + 2));
}
DDS_Security_SharedSecretHandle MadeUpSecret::handle() const {
  return reinterpret_cast<DDS_Security_SharedSecretHandle>(&layout);
}

Keys keys_of(int message, int submessage, int payload) {
  constexpr std::uint32_t kValid = 1u << 31;
  const auto mask = [](int kind) -> std::uint32_t { return kind == 2 || kind == 4 ? 1 : 0; };
  Keys keys;
  keys.participant.is_access_protected = 1;
  keys.participant.is_rtps_protected = message != 0;
  keys.participant.plugin_participant_attributes =
      kValid | mask(message) | (message > 2 ? 1u << 3 : 0);
  keys.endpoint.is_submessage_protected = submessage != 0;
  keys.endpoint.is_payload_protected = payload != 0;
  keys.endpoint.is_key_protected = payload == 2;
  keys.endpoint.plugin_endpoint_attributes =
      kValid | mask(submessage) | mask(payload) << 1 | (submessage > 2 ? 1u << 2 : 0);
  return keys;
}

}  // namespace ddssec::driver
