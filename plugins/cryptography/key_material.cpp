#include "plugins/cryptography/key_material.hpp"

#include <algorithm>
#include <array>

#include "plugins/spi/property_names.hpp"

namespace ddssec::cryptography {
namespace {

constexpr std::string_view kKeyMaterialProperty = "dds.cryp.keymat";
// Cyclone DDS writes a NONE material of 24 octets, Fast DDS one of 44; no product writes more.
constexpr std::size_t kMinNoneSize = 24;
constexpr std::size_t kMaxNoneSize = 128;

// The first four are ordered by the last octet of the kind, from 1.
constexpr std::array kKinds = {
    KindTraits{kAes128Gmac, Cipher::aes128_gcm, false},
    KindTraits{kAes128Gcm, Cipher::aes128_gcm, true},
    KindTraits{kAes256Gmac, Cipher::aes256_gcm, false},
    KindTraits{kAes256Gcm, Cipher::aes256_gcm, true},
    KindTraits{kChachaPoly1305Mac, Cipher::chacha20_poly1305, false},
    KindTraits{kChachaPoly1305, Cipher::chacha20_poly1305, true},
};

bool all_zero(BytesView octets) {
  std::uint8_t seen = 0;
  for (const auto octet : octets) seen |= octet;
  return seen == 0;
}

Result<KeyMaterial> parse_none(BytesView octets) {
  if (octets.size() < kMinNoneSize || octets.size() > kMaxNoneSize || !all_zero(octets))
    return fail(Code::key_material_length);
  return KeyMaterial{};
}

template <class Id>
Result<Id> read_id(Reader& reader) {
  auto octets = reader.read_bytes(Id::size);
  if (!octets) return fail(Code::key_material_length);
  return Id::from(*octets);
}

// Reads a sequence<octet> of exactly `size` octets that are not all zero, and copies it into an
// object that wipes it.
template <class Key>
Result<Key> read_key(Reader& reader, std::size_t size) {
  const auto octets = reader.read_octet_sequence();
  if (!octets || octets->size() != size) return fail(Code::key_material_length);
  if (size != 0 && all_zero(*octets)) return fail(Code::key_material_all_zero);
  return Key::copy_of(*octets);
}

}  // namespace

std::optional<KindTraits> traits_of(TransformKind kind) {
  const unsigned last = kind.octets[3];
  const unsigned first_of_ours = kChachaPoly1305Mac.octets[3];
  const unsigned index = last >= first_of_ours ? last - first_of_ours + 4 : last - 1;
  if (index >= kKinds.size() || kKinds[index].kind.octets[3] != last) return std::nullopt;
  return kKinds[index];
}

TransformKind kind_for(Cipher cipher, bool encrypts) {
  return std::ranges::find_if(
             kKinds,
             [&](const auto& row) { return row.cipher == cipher && row.encrypts == encrypts; })
      ->kind;
}

KeyMaterial KeyMaterial::clone() const {
  return {kind,
          salt.clone(),
          sender_key_id,
          sender_key.clone(),
          receiver_key_id,
          receiver_key.clone(),
          position};
}

bool KeyMaterial::operator==(const KeyMaterial& other) const {
  return kind == other.kind && salt == other.salt && sender_key_id == other.sender_key_id &&
         sender_key == other.sender_key && receiver_key_id == other.receiver_key_id &&
         receiver_key == other.receiver_key;
}

Bytes serialize_key_material(const KeyMaterial& material) {
  // The memory is reserved at once, so that no smaller block with some of the keys is freed without
  // being wiped.
  Bytes out;
  const auto position = material.position ? serialize(*material.position) : Bytes();
  out.reserve(24 + 3 * MasterKey::capacity + position.size());
  const auto append = [&](BytesView octets) {
    out.insert(out.end(), octets.begin(), octets.end());
  };
  const auto sequence = [&](BytesView octets) {
    append(std::array<std::uint8_t, 4>{0, 0, 0, static_cast<std::uint8_t>(octets.size())});
    append(octets);
  };
  append(material.kind.view());
  material.salt.expose(sequence);
  append(material.sender_key_id.view());
  material.sender_key.expose(sequence);
  append(material.receiver_key_id.view());
  material.receiver_key.expose(sequence);
  append(position);
  return out;
}

Result<KeyMaterial> parse_key_material(BytesView octets) {
  Reader reader(octets);
  DDSSEC_ASSIGN_OR_RETURN(const auto kind, read_id<TransformKind>(reader));
  if (kind == kKindNone) return parse_none(octets);
  const auto traits = traits_of(kind);
  if (!traits) return fail(Code::key_material_kind_unknown, {.found = kind.to_string()});
  KeyMaterial material{.kind = kind};
  DDSSEC_ASSIGN_OR_RETURN(material.salt, read_key<MasterSalt>(reader, traits->key_size()));
  DDSSEC_ASSIGN_OR_RETURN(material.sender_key_id, read_id<KeyId>(reader));
  DDSSEC_ASSIGN_OR_RETURN(material.sender_key, read_key<MasterKey>(reader, traits->key_size()));
  DDSSEC_ASSIGN_OR_RETURN(material.receiver_key_id, read_id<KeyId>(reader));
  // Id 0 means that there is no receiver-specific key, so none may follow.
  DDSSEC_ASSIGN_OR_RETURN(
      material.receiver_key,
      read_key<MasterReceiverKey>(reader, material.has_receiver_key() ? traits->key_size() : 0));
  if (!reader.at_end()) {
    DDSSEC_ASSIGN_OR_RETURN(const auto position, reader.read_bytes(reader.remaining()));
    material.position = parse_send_position(position);
    if (!material.position) return fail(Code::key_material_length);
  }
  if (material.sender_key_id.is_zero()) return fail(Code::key_material_key_id);
  return material;
}

spi::Token crypto_token(const KeyMaterial& material) {
  auto octets = serialize_key_material(material);
  auto token = token_of_material(octets);
  wipe(octets);
  return token;
}

spi::Token token_of_material(BytesView octets) {
  spi::Token token;
  token.class_id = spi::class_id::kCrypto;
  token.binary_properties.push_back({std::string(kKeyMaterialProperty), to_bytes(octets), true});
  return token;
}

Result<KeyMaterial> read_crypto_token(const spi::Token& token) {
  if (token.class_id != spi::class_id::kCrypto)
    return fail(Code::crypto_token_class,
                {.expected = std::string(spi::class_id::kCrypto), .found = token.class_id});
  if (!token.properties.empty() || token.binary_properties.size() != 1 ||
      token.binary_properties.front().name != kKeyMaterialProperty)
    return fail(Code::crypto_token_form);
  return parse_key_material(token.binary_properties.front().value);
}

}  // namespace ddssec::cryptography
