#include "plugins/cryptography/key_owner.hpp"

#include <bit>
#include <string>

#include "base/reader.hpp"
#include "plugins/cryptography/entities.hpp"
#include "plugins/cryptography/wire.hpp"

namespace ddssec::cryptography {
namespace {

// In the payload of a ParticipantGenericMessage, its encapsulation header included.
constexpr std::size_t kSourceEndpointAt = 84;  ///< source_endpoint_guid
constexpr std::size_t kClassIdAt = 100;        ///< message_class_id

/// sender_key_id of the first token. The key itself is not touched.
Result<KeyId> first_key_id(BytesView payload) {
  Reader in(payload.subspan(4), payload[1] % 2 == 1 ? Endian::little : Endian::big);
  DDSSEC_TRY(in.skip(kClassIdAt - 4));
  DDSSEC_TRY(in.read_string());
  if (DDSSEC_TRY(in.read_aligned<std::uint32_t>()) == 0) return fail(Code::malformed);
  DDSSEC_TRY(in.read_string());  // the token's class id
  const auto properties = DDSSEC_TRY(in.read_aligned<std::uint32_t>());
  const auto binary_properties = DDSSEC_TRY(in.read_aligned<std::uint32_t>());
  if (properties != 0 || binary_properties != 1) return fail(Code::malformed);
  DDSSEC_TRY(in.read_string());                  // dds.cryp.keymat
  DDSSEC_TRY(in.read_aligned<std::uint32_t>());  // its length: parse_key_material checks it
  in.set_endian(Endian::big);                    // DDS-Security 9.5.2.1.1
  DDSSEC_TRY(in.skip(TransformKind::size));
  DDSSEC_TRY(in.skip(DDSSEC_TRY(in.read<std::uint32_t>())));  // master_salt
  return KeyId::from(DDSSEC_TRY(in.read_bytes(KeyId::size)));
}

std::uint32_t word_of(KeyId key) { return std::bit_cast<std::uint32_t>(key.octets); }

/// Where a submessage names the endpoint that sent it, and the octets of its fixed fields.
struct Shape {
  std::string_view field;
  std::size_t sender_at;
  std::size_t least_size;
};

Shape shape_of(std::uint8_t id) {
  using namespace submessage_id;
  switch (id) {
    case kData:
      return {"writerId", 12, 24};
    case kDataFrag:
      return {"writerId", 12, 36};
    case kAckNack:
      return {"readerId", 4, 28};
    case kNackFrag:
      return {"readerId", 4, 32};
    case kHeartbeatFrag:
      return {"writerId", 8, 28};
    default:  // HEARTBEAT and GAP
      return {"writerId", 8, 32};
  }
}


std::unexpected<Error> not_of_sender(const Shape& shape, std::string expected, EntityId named) {
  return fail(Code::submessage_not_of_sender, {.document = "a protected submessage",
                                               .field = std::string(shape.field),
                                               .expected = std::move(expected),
                                               .found = named.to_string()});
}

}  // namespace

std::optional<KeyOwner> owner_in_tokens(BytesView payload) {
  if (payload.size() < kClassIdAt) return std::nullopt;
  const auto guid = payload.subspan(kSourceEndpointAt);
  if (GuidPrefix::from(guid.first(GuidPrefix::size)).is_zero()) return std::nullopt;
  const auto key = first_key_id(payload);
  if (!key || key->is_zero()) return std::nullopt;
  return KeyOwner{*key, EntityId::from(guid.subspan(GuidPrefix::size, EntityId::size))};
}

void KeyOwners::note(const KeyOwner& owner) {
  const std::lock_guard lock(mutex_);
  const auto key = word_of(owner.key);
  const auto [known, is_new] = owners_.try_emplace(key, owner.endpoint);
  if (!is_new) {
    if (known->second != owner.endpoint) known->second = {};
    return;
  }
  order_.push_back(key);
  if (order_.size() <= kMaxKeys) return;
  owners_.erase(order_.front());
  order_.pop_front();
}

Result<EntityId> KeyOwners::owner_of(KeyId key) const {
  const std::lock_guard lock(mutex_);
  const auto known = owners_.find(word_of(key));
  if (known == owners_.end()) return EntityId{};
  if (known->second.is_zero())
    return fail(Code::key_material_key_id,
                {.document = "crypto tokens",
                 .field = "sender_key_id",
                 .expected = "a key of one endpoint",
                 .found = key.to_string() + ", which several endpoints of its sender have"});
  return known->second;
}

Status check_speaker(const RemoteEndpoint& sender, BytesView plain) {
  const auto header = read_submessage_header(plain);
  if (header.id == submessage_id::kInfoTimestamp) return {};
  const auto shape = shape_of(header.id);
  // With length 0 the host reads on after the group, so that all fields must stand in it.
  const auto least = header.length == 0 ? shape.least_size : shape.sender_at + EntityId::size;
  if (plain.size() < least)
    return fail(Code::secure_group_malformed, {.document = "a protected submessage",
                                               .expected = std::to_string(least) + " octets",
                                               .found = std::to_string(plain.size())});
  const auto named = EntityId::from(plain.subspan(shape.sender_at, EntityId::size));
  if (sender.local.is_volatile) {
    const auto due = shape.field == "readerId" ? kVolatileReader : kVolatileWriter;
    return named == due ? Status() : not_of_sender(shape, due.to_string(), named);
  }
  const auto* const keys = sender.remote_keys.read();
  const auto owner = keys == nullptr ? EntityId{} : keys->owner;
  if (!owner.is_zero())
    return named == owner ? Status() : not_of_sender(shape, owner.to_string(), named);
  if (is_builtin(named) == sender.local.is_builtin) return {};
  return not_of_sender(
      shape, sender.local.is_builtin ? "a builtin endpoint" : "no builtin endpoint", named);
}

}  // namespace ddssec::cryptography
