#include "wire/info_timestamp.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::uint8_t kFlagInvalidate = 0x02;

}  // namespace

Result<InfoTimestamp> read_info_timestamp(const SubmessageView& view) {
  if (view.has(kFlagInvalidate)) return InfoTimestamp{};
  auto reader = view.reader();
  DDSSEC_ASSIGN_OR_RETURN(const auto time, read_time(reader));
  return time.is_valid() ? InfoTimestamp{time} : InfoTimestamp{};
}

void write(SpanWriter& out, const InfoTimestamp& info) {
  const SubmessageScope scope(out, SubmessageId::info_timestamp, info.time ? 0 : kFlagInvalidate);
  if (info.time) write_time(out, *info.time);
}

}  // namespace ddssec::rtps
