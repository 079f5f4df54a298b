#include "plugins/cryptography/send_position.hpp"

#include <algorithm>

#include "base/reader.hpp"
#include "base/writer.hpp"

namespace ddssec::cryptography {
namespace {

constexpr std::size_t kHeadSize = 12, kRangeSize = 8;

// True if the message with that session and suffix was protected before `position`.
bool is_before(std::uint32_t session, std::uint64_t suffix, const SendPosition& position) {
  const auto has_it = [session](const SessionRange& range) { return range.contains(session); };
  if (std::ranges::none_of(position.begun, has_it)) return false;
  return session != position.session || static_cast<std::int64_t>(suffix - position.suffix) < 0;
}

}  // namespace

IvParts parts_of(const Iv& iv) noexcept {
  IvParts parts;
  for (std::size_t i = 0; i < 4; ++i) parts.session = parts.session << 8 | iv[i];
  for (std::size_t i = 4; i < iv.size(); ++i) parts.suffix = parts.suffix << 8 | iv[i];
  return parts;
}

bool SendPosition::has_passed(const Iv& iv) const noexcept {
  const auto [session_id, of_message] = parts_of(iv);
  return is_before(session_id, of_message, *this);
}

bool SendPosition::is_after(const SendPosition& other) const noexcept {
  return is_before(other.session, other.suffix, *this);
}

Bytes serialize(const SendPosition& position) {
  const auto ranges =
      std::span(position.begun).first(std::min(position.begun.size(), SendPosition::kMaxRanges));
  Writer out(Endian::big, kHeadSize + ranges.size() * kRangeSize);
  out.write(position.suffix);
  out.write(position.session);
  for (const auto& range : ranges) {
    out.write(range.first);
    out.write(range.further);
  }
  return out.take();
}

std::optional<SendPosition> parse_send_position(BytesView octets) {
  Reader reader(octets, Endian::big);
  const auto suffix = reader.read<std::uint64_t>();
  const auto session = reader.read<std::uint32_t>();
  if (!suffix || !session) return std::nullopt;
  SendPosition out{*session, *suffix};
  while (!reader.at_end()) {
    const auto first = reader.read<std::uint32_t>(), further = reader.read<std::uint32_t>();
    if (!first || !further || out.begun.size() >= SendPosition::kMaxRanges) return std::nullopt;
    out.begun.push_back({*first, *further});
  }
  return out.begun.empty() ? std::nullopt : std::optional(std::move(out));
}

}  // namespace ddssec::cryptography
