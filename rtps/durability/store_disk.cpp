#include "rtps/durability/store_disk.hpp"

#include <algorithm>
#include <filesystem>
#include <limits>

namespace ddssec::rtps {

std::size_t room_on_disk(const std::string& path, std::size_t pages) {
  constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max() / 4;
  constexpr std::uintmax_t kPart = 16, kMinKept = 256 << 10, kMaxKept = 4 << 20;
  std::error_code unknown;
  const auto space = std::filesystem::space(path, unknown);
  if (unknown) return kAll;
  const auto size = std::filesystem::file_size(path, unknown);
  if (unknown) return kAll;
  const auto unwritten = pages - std::min<std::uintmax_t>(pages, size);
  const auto kept = std::clamp(space.capacity / kPart, kMinKept, kMaxKept) + unwritten;
  return std::min<std::uintmax_t>(kAll, space.available - std::min(space.available, kept));
}

}  // namespace ddssec::rtps
