#include "plugins/cryptography/token_destination.hpp"

#include <string>
#include <string_view>
#include <utility>

#include "plugins/cryptography/crypto_framing.hpp"
#include "plugins/cryptography/data_piece.hpp"

namespace ddssec::cryptography {
namespace {

// The position of destination_participant_guid in a ParticipantGenericMessage with its
// encapsulation, the same in every byte order and in plain CDR 1 and 2.
constexpr std::size_t kDestinationAt = 52;

std::unexpected<Error> refused_destination_error(ErrorDetails details) {
  details.document = "a key token message";
  return fail(Code::token_destination_refused, std::move(details));
}

std::unexpected<Error> unreadable_destination_error(std::string_view why) {
  return refused_destination_error({.note = std::string(why)});
}

}  // namespace

Status check_token_destination(BytesView submessage, const std::optional<GuidPrefix>& receiver,
                               FragmentedTokens& sent) {
  const auto id = submessage[0];
  if (id != submessage_id::kData && id != submessage_id::kDataFrag) return {};
  if (!writer_of_data(submessage)) return unreadable_destination_error("it ends too early");
  const auto piece = read_data_piece(submessage);
  if (!piece) return unreadable_destination_error("its lengths contradict one another");
  if (!piece->begins_sample) {
    if (sent.contains(piece->number)) return {};
    return unreadable_destination_error(
        "a fragment does not follow the one that names the destination");
  }
  const auto payload = piece->payload;
  if (!piece->has_data || piece->has_key || !is_plain_cdr(payload) ||
      payload.size() < kDestinationAt + GuidPrefix::size)
    return unreadable_destination_error("its destination_participant_guid cannot be read");
  const auto named = GuidPrefix::from(payload.subspan(kDestinationAt, GuidPrefix::size));
  if (receiver && named != *receiver)
    return refused_destination_error({.field = "destination_participant_guid",
                                      .expected = receiver->to_string(),
                                      .found = named.to_string()});
  if (piece->is_fragment) sent.note(piece->number);
  return {};
}

void note_fragment(BytesView submessage, FragmentedTokens& sent) {
  if (submessage[0] != submessage_id::kDataFrag) return;
  if (const auto piece = read_data_piece(submessage)) sent.note(piece->number);
}

Status check_fragment_request(BytesView submessage, const FragmentedTokens& sent) {
  if (submessage[0] != submessage_id::kNackFrag) return {};
  const auto number = read_fragment_request(submessage);
  if (number && sent.contains(*number)) return {};
  return fail(Code::token_fragment_not_sent,
              {.document = "a NACK_FRAG",
               .field = "writerSN",
               .expected = "a message in fragments to this peer",
               .found = number ? std::to_string(*number) : "no number"});
}

}  // namespace ddssec::cryptography
