#include "plugins/cryptography/replay_window.hpp"

namespace ddssec::cryptography {
namespace {

// Sessions of one stream are at most this far apart. Those of another stream begin at a random
// number.
constexpr std::uint32_t kMaxDistance = 1 << 16;

// Numbers wrap around, so their order is the sign of their difference.
bool is_after(const IvParts& a, const IvParts& b) {
  if (a.session != b.session) return static_cast<std::int32_t>(a.session - b.session) > 0;
  return static_cast<std::int64_t>(a.suffix - b.suffix) > 0;
}

}  // namespace

bool ReplayWindow::Stream::has(std::uint32_t session) const {
  const auto newest = newest_[(first_ + size_ - 1) % kMaxLate].session;
  return session - newest <= kMaxDistance || newest - session <= kMaxDistance;
}

bool ReplayWindow::Stream::accept(IvParts message) {
  if (passed_ && !is_after(message, *passed_)) return false;
  auto at = size_;  // most messages come in their order
  while (at > 0 && is_after(place(at - 1), message)) --at;
  if (at > 0 && place(at - 1) == message) return false;
  if (size_ == kMaxLate) {
    passed_ = at == 0 ? message : place(0);
    if (at == 0) return true;
    first_ = (first_ + 1) % kMaxLate;
    --size_, --at;
  }
  for (auto to = size_++; to > at; --to) place(to) = place(to - 1);
  place(at) = message;
  return true;
}

bool ReplayWindow::accept(const Iv& iv) {
  const auto message = parts_of(iv);
  const std::lock_guard lock(mutex_);
  for (auto& stream : streams_)
    if (stream.has(message.session)) return stream.accept(message);
  if (streams_.size() >= kMaxStreams) return false;
  streams_.emplace_back(message);
  return true;
}

}  // namespace ddssec::cryptography
