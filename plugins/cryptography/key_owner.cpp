#include "plugins/cryptography/key_owner.hpp"

#include <string>

#include "plugins/cryptography/crypto_framing.hpp"
#include "plugins/cryptography/entities.hpp"
#include "wire/entity_ids.hpp"
#include "wire/submessage_layout.hpp"

namespace ddssec::cryptography {
namespace {

// An unknown submessage is checked at the positions of a HEARTBEAT, which most submessages share.
rtps::SubmessageLayout layout_of(std::uint8_t id) {
  constexpr auto kUsual = *rtps::layout_of(SubmessageId::heartbeat);
  return rtps::layout_of(SubmessageId{id}).value_or(kUsual);
}

std::unexpected<Error> not_of_sender_error(const rtps::SubmessageLayout& layout,
                                           std::string expected, EntityId named) {
  return fail(Code::submessage_not_of_sender,
              {.document = "a protected submessage",
               .field = layout.is_of_reader ? "readerId" : "writerId",
               .expected = std::move(expected),
               .found = named.to_string()});
}

}  // namespace

Status check_speaker(const RemoteEndpointCrypto& sender, BytesView plain) {
  const auto header = read_submessage_header(plain);
  if (header.id == submessage_id::kInfoTimestamp) return {};
  const auto layout = layout_of(header.id);
  // With length 0 the host continues to read after the group, so all fields must be inside the
  // group.
  const auto least = header.length == 0 ? layout.min_size : layout.sender_at() + EntityId::size;
  if (plain.size() < least)
    return fail(Code::secure_group_malformed, {.document = "a protected submessage",
                                               .expected = std::to_string(least) + " octets",
                                               .found = std::to_string(plain.size())});
  const auto named = EntityId::from(plain.subspan(layout.sender_at(), EntityId::size));
  if (sender.local.is_volatile) {
    const auto due =
        layout.is_of_reader ? rtps::kVolatileMessageReader : rtps::kVolatileMessageWriter;
    return named == due ? Status() : not_of_sender_error(layout, due.to_string(), named);
  }
  const auto* const keys = sender.remote_keys.read();
  const auto owner = keys == nullptr ? EntityId{} : keys->owner;
  if (!owner.is_zero())
    return named == owner ? Status() : not_of_sender_error(layout, owner.to_string(), named);
  if (rtps::is_builtin(named) == sender.local.is_builtin) return {};
  return not_of_sender_error(
      layout, sender.local.is_builtin ? "a builtin endpoint" : "no builtin endpoint", named);
}

}  // namespace ddssec::cryptography
