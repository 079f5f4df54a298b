#include "wire/header_extension.hpp"

#include "wire/parameter_list.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::uint8_t kFlagLength = 0x02;
constexpr std::uint8_t kFlagTimestamp = 0x04;
constexpr std::uint8_t kFlagUExtension4 = 0x08;
constexpr std::uint8_t kFlagWExtension8 = 0x10;
constexpr std::uint8_t kFlagsChecksum = 0x60;
constexpr std::uint8_t kFlagParameters = 0x80;

// Returns the size of the checksum: none, CRC-32C, CRC-64/XZ or MD5.
constexpr std::size_t checksum_size(std::uint8_t flags) {
  constexpr std::size_t kSizes[] = {0, 4, 8, 16};
  return kSizes[(flags & kFlagsChecksum) >> 5];
}

}  // namespace

Result<HeaderExtension> read_header_extension(const SubmessageView& view,
                                              std::size_t message_size) {
  auto reader = view.reader();
  HeaderExtension out;
  if (view.has(kFlagLength)) {
    DDSSEC_ASSIGN_OR_RETURN(out.message_length, reader.read<std::uint32_t>());
  }
  if (view.has(kFlagTimestamp)) {
    DDSSEC_ASSIGN_OR_RETURN(out.send_time, read_time(reader));
  }
  if (view.has(kFlagUExtension4)) DDSSEC_RETURN_IF_ERROR(reader.skip(4));
  if (view.has(kFlagWExtension8)) DDSSEC_RETURN_IF_ERROR(reader.skip(8));
  DDSSEC_RETURN_IF_ERROR(reader.skip(checksum_size(view.flags)));
  if (view.has(kFlagParameters))
    DDSSEC_RETURN_IF_ERROR(parameter_list_prefix(reader.rest(), view.endian()));
  if (out.message_length && *out.message_length != message_size)
    return fail(Code::rtps_submessage_overrun);
  return out;
}

}  // namespace ddssec::rtps
