#include "rtps/reliability/end_mark.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::size_t kMarkAt = 2;  // the first octet of the options
constexpr std::uint8_t kEnds = 0x80, kKeyOnly = 4, kUnregistered = 2, kDisposed = 1;

}  // namespace

std::uint8_t end_mark(const StatusInfo& status, bool is_key_only) {
  if (!status.disposed && !status.unregistered) return 0;
  return static_cast<std::uint8_t>(kEnds | (is_key_only ? kKeyOnly : 0) |
                                   (status.unregistered ? kUnregistered : 0) |
                                   (status.disposed ? kDisposed : 0));
}

bool has_end_mark(BytesView payload, std::uint8_t mark) {
  return payload.size() > kMarkAt ? payload[kMarkAt] == mark : mark == 0;
}

void set_end_mark(MutableBytes payload, std::uint8_t mark) {
  if (payload.size() > kMarkAt) payload[kMarkAt] = mark;
}

}  // namespace ddssec::rtps
