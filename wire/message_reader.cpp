#include "wire/message_reader.hpp"

namespace ddssec::rtps {
namespace {

// True for a submessage whose body may be empty. For all others, length 0 means "to the end of the
// message" (RTPS 9.4.5.1.3).
bool may_be_empty(SubmessageId id) {
  return id == SubmessageId::pad || id == SubmessageId::info_timestamp;
}

}  // namespace

Result<MessageReader> MessageReader::open(BytesView message) {
  DDSSEC_ASSIGN_OR_RETURN(const auto header, read_header(message));
  return MessageReader(header, message.subspan(kHeaderSize));
}

Result<std::optional<SubmessageView>> MessageReader::next() {
  if (rest_.empty()) return std::nullopt;
  if (rest_.size() < kSubmessageHeaderSize) return fail(Code::truncated);
  SubmessageView view{static_cast<SubmessageId>(rest_[0]), rest_[1], {}, {}};
  DDSSEC_ASSIGN_OR_RETURN(std::size_t length,
                          Reader(rest_.subspan(2, 2), view.endian()).read<std::uint16_t>());
  const auto left = rest_.size() - kSubmessageHeaderSize;
  if (length == 0 && !may_be_empty(view.id)) length = left;
  // Only the last submessage may have a length that is not a multiple of 4; otherwise the next one
  // would be misaligned.
  if (length > left || (length % 4 != 0 && length != left))
    return fail(Code::rtps_submessage_overrun);
  view.whole = rest_.first(kSubmessageHeaderSize + length);
  view.body = view.whole.subspan(kSubmessageHeaderSize);
  rest_ = rest_.subspan(view.whole.size());
  return view;
}

}  // namespace ddssec::rtps
