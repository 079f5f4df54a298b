#include "plugins/cryptography/key_owner.hpp"

#include <string>

#include "plugins/cryptography/crypto_framing.hpp"
#include "plugins/cryptography/entities.hpp"

namespace ddssec::cryptography {
namespace {

// The position of the sender's entity id in a submessage, and the size of its fixed fields.
struct Shape {
  std::string_view field;
  std::size_t sender_at;
  std::size_t min_size;
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

std::unexpected<Error> not_of_sender_error(const Shape& shape, std::string expected,
                                           EntityId named) {
  return fail(Code::submessage_not_of_sender, {.document = "a protected submessage",
                                               .field = std::string(shape.field),
                                               .expected = std::move(expected),
                                               .found = named.to_string()});
}

}  // namespace

Status check_speaker(const RemoteEndpointCrypto& sender, BytesView plain) {
  const auto header = read_submessage_header(plain);
  if (header.id == submessage_id::kInfoTimestamp) return {};
  const auto shape = shape_of(header.id);
  // With length 0 the host continues to read after the group, so all fields must be inside the
  // group.
  const auto least = header.length == 0 ? shape.min_size : shape.sender_at + EntityId::size;
  if (plain.size() < least)
    return fail(Code::secure_group_malformed, {.document = "a protected submessage",
                                               .expected = std::to_string(least) + " octets",
                                               .found = std::to_string(plain.size())});
  const auto named = EntityId::from(plain.subspan(shape.sender_at, EntityId::size));
  if (sender.local.is_volatile) {
    const auto due = shape.field == "readerId" ? kVolatileReader : kVolatileWriter;
    return named == due ? Status() : not_of_sender_error(shape, due.to_string(), named);
  }
  const auto* const keys = sender.remote_keys.read();
  const auto owner = keys == nullptr ? EntityId{} : keys->owner;
  if (!owner.is_zero())
    return named == owner ? Status() : not_of_sender_error(shape, owner.to_string(), named);
  if (is_builtin(named) == sender.local.is_builtin) return {};
  return not_of_sender_error(
      shape, sender.local.is_builtin ? "a builtin endpoint" : "no builtin endpoint", named);
}

}  // namespace ddssec::cryptography
