#include "plugins/cryptography/sender_part.hpp"

#include <algorithm>

#include "plugins/cryptography/builtin_checks.hpp"
#include "plugins/cryptography/crypto_framing.hpp"
#include "plugins/cryptography/data_piece.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::cryptography {
namespace {

// ParticipantGenericMessage (DDS-Security 1.2, clause 7.3.22) begins with GUIDs and sequence
// numbers only, so these positions are the same in every byte order and in plain CDR 1 and 2.
constexpr std::size_t kSourceAt = 4;           // message_identity.source_guid
constexpr std::size_t kSourceEndpointAt = 84;  // source_endpoint_guid
constexpr std::size_t kAddressesSize = 100;    // the octets before message_class_id

// ---- whole messages

// True if all parts of a SEC_ group have the same byte order. Cyclone DDS reads all their lengths
// in the order of SEC_PREFIX, so with one order there is only one way to read them.
bool is_of_one_order(BytesView group, std::size_t prefix_size) {
  const auto order = group[1] & kFlagLittleEndian;
  auto rest = group.subspan(prefix_size);
  for (int part = 0; part < 2; ++part) {
    const auto size = size_of_first_submessage(rest);
    if (!size || (rest[1] & kFlagLittleEndian) != order) return false;
    rest = rest.subspan(*size);
  }
  return true;
}

// True if a submessage that is only signed follows SEC_PREFIX. The host verifies it with its own
// key, so a change here would break its signature.
bool begins_signed_group(BytesView group, std::size_t prefix_size) {
  if (group[0] != submessage_id::kSecPrefix) return false;
  const auto body = group.subspan(prefix_size);
  const auto size = size_of_first_submessage(body);
  return size && *size < body.size() && body[*size] == submessage_id::kSecPostfix;
}

bool are_of_one_subject(const GuidPrefix& a, const GuidPrefix& b) {
  return std::equal(a.octets.begin(), a.octets.begin() + 6, b.octets.begin());
}

Error unreadable_group_error() {
  return Error(Code::secure_group_malformed, {.document = "a protected message"});
}

// True for samples of the builtin writers of DDS-XTypes 7.6.3.3.3. Some of them crash the process
// that reads them.
bool is_type_lookup(BytesView submessage) {
  const auto writer = writer_of_data(submessage);
  return writer &&
         (*writer == rtps::kTypeLookupRequestWriter || *writer == rtps::kTypeLookupReplyWriter);
}

// Checks the first submessage of `rest`; the sender's part ends before a submessage that fails.
// `source` is the participant in whose name it is sent.
Result<TypeInformationAt> check_next(BytesView rest, std::size_t size, const GuidPrefix& sender,
                                     GuidPrefix& source, DiscoveryOfPeers& peers) {
  const auto id = rest[0];
  if (id == submessage_id::kSecPrefix && !is_of_one_order(rest, size))
    return std::unexpected(unreadable_group_error());
  if (id != submessage_id::kInfoSource)
    return check_builtin_source(rest.first(size), source, peers);
  if (size < kInfoSourceSize) return std::unexpected(unreadable_group_error());
  const auto named = GuidPrefix::from(rest.subspan(12, GuidPrefix::size));
  source = named;
  if (named == sender || are_of_one_subject(named, sender)) return TypeInformationAt{};
  return fail(Code::info_source_mismatch, {.document = "a protected message",
                                           .field = "INFO_SRC",
                                           .expected = sender.to_string(),
                                           .found = named.to_string(),
                                           .note = "what follows it was dropped"});
}

// True if only this submessage does not pass, and its sender will send it again.
bool comes_again(const Error& error) {
  return error.code() == Code::builtin_fragment_early ||
         error.code() == Code::announcements_delayed;
}

// True if a closed writer sends the submessage in the clear. Every participant with the key of the
// message can write such a submessage in the name of any other, so nothing in it may count. In a
// signed group it counts once the writer's key has verified it.
bool is_of_closed_writer(BytesView submessage, const DiscoveryOfPeers& peers) {
  auto writer = writer_of_data(submessage);
  if (!writer)
    if (const auto skipped = read_skipped(submessage)) writer = skipped->writer;
  return writer && discovery_topic_of(*writer) != nullptr && peers.is_closed(*writer);
}

// ---- key tokens

std::unexpected<Error> unreadable_token_error(std::string_view why) {
  return fail(Code::token_source_unreadable,
              {.document = "a key token message", .note = std::string(why)});
}

Status check_name(std::string_view field, const GuidPrefix& expected, const GuidPrefix& found) {
  if (found == expected) return {};
  return fail(Code::token_source_mismatch, {.document = "a key token message",
                                            .field = std::string(field),
                                            .expected = expected.to_string(),
                                            .found = found.to_string()});
}

}  // namespace

SenderPart part_of_sender(BytesView content, const GuidPrefix& sender, DiscoveryOfPeers& peers) {
  auto source = sender;
  auto signed_at = content.size();
  SenderPart part{.size = content.size(), .ended = std::nullopt};
  for (auto rest = content; !rest.empty();) {
    const auto here = content.size() - rest.size();
    const auto end = [&](Error why) {
      if (why.code() == Code::info_source_mismatch) part.named = source;
      part.ended = std::move(why);
      part.size = here;
    };
    const auto size = size_of_first_submessage(rest);
    if (!size) {
      end(unreadable_group_error());
      break;
    }
    const bool is_closed = is_of_closed_writer(rest.first(*size), peers);
    auto found = is_closed ? TypeInformationAt{} : check_next(rest, *size, sender, source, peers);
    if (is_closed && here != signed_at) {
      part.hidden.push_back(here);
    } else if (!found && comes_again(found.error())) {
      part.hidden.push_back(here);
    } else if (!found) {
      end(std::move(found).error());
      break;
    } else if (*found && here != signed_at) {
      part.types.push_back(**found);
      part.types.back().at += static_cast<std::uint32_t>(here);
    }
    if (is_type_lookup(rest.first(*size))) part.lookups.push_back(here);
    if (begins_signed_group(rest, *size)) signed_at = here + *size;
    rest = rest.subspan(*size);
  }
  return part;
}

Status check_token_source(BytesView submessage, bool is_key_exchange,
                          const std::optional<GuidPrefix>& peer) {
  const auto writer = writer_of_data(submessage);
  if (!writer) {
    const auto id = submessage[0];
    const bool is_data = id == submessage_id::kData || id == submessage_id::kDataFrag;
    return is_key_exchange && is_data ? unreadable_token_error("it ends too early") : Status();
  }
  if ((*writer == rtps::kVolatileMessageWriter) != is_key_exchange)
    return fail(Code::submessage_not_of_sender,
                {.field = "writerId", .found = writer->to_string()});
  if (!is_key_exchange) return {};
  // A message that names no reader reaches all participants in the process, and a host that trusts
  // it would hold its ticket twice.
  const auto reader = reader_of_data(submessage);
  if (reader != rtps::kVolatileMessageReader)
    return fail(Code::submessage_not_of_sender, {.field = "readerId", .found = reader.to_string()});
  const auto piece = read_data_piece(submessage);
  if (!piece) return unreadable_token_error("its lengths contradict one another");
  // If only the key or its hash came, Cyclone DDS dereferences a null pointer.
  if (!piece->has_data || piece->has_key)
    return unreadable_token_error("it is not data, but a key or nothing");
  // Cyclone DDS would keep each fragment until all have come, up to 2 GB.
  const auto payload = piece->payload;
  if (piece->is_fragment && payload.size() < piece->sample_size)
    return unreadable_token_error("it comes in several fragments");
  if (payload.size() < kAddressesSize) return unreadable_token_error("it is too short");
  if (!is_plain_cdr(payload)) return unreadable_token_error("its encapsulation is not plain CDR");
  const auto source = GuidPrefix::from(payload.subspan(kSourceAt, GuidPrefix::size));
  DDSSEC_RETURN_IF_ERROR(check_name("message_identity.source_guid", peer.value_or(source), source));
  const auto endpoint = GuidPrefix::from(payload.subspan(kSourceEndpointAt, GuidPrefix::size));
  if (endpoint.is_zero()) return {};  // a participant's tokens
  return check_name("source_endpoint_guid", peer.value_or(source), endpoint);
}

}  // namespace ddssec::cryptography
