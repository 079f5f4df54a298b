#include "plugins/cryptography/replay_window.hpp"

#include <algorithm>
#include <utility>

namespace ddssec::cryptography {
namespace {

/// Sessions of a stream lie this close together; another one's begin at random.
constexpr std::uint32_t kMaxDistance = 1 << 16;

/// Numbers count past the greatest one, so their order is the sign of their difference.
bool is_after(const IvParts& a, const IvParts& b) {
  if (a.session != b.session) return static_cast<std::int32_t>(a.session - b.session) > 0;
  return static_cast<std::int64_t>(a.suffix - b.suffix) > 0;
}

}  // namespace

bool ReplayWindow::Stream::has(std::uint32_t session) const {
  return session - newest_.session <= kMaxDistance || newest_.session - session <= kMaxDistance;
}

bool ReplayWindow::Stream::accept(IvParts message) {
  if (is_after(message, newest_)) {
    newest_ = message;
  } else if ((passed_ && !is_after(message, *passed_)) ||
             std::ranges::find(recent_, message) != recent_.end()) {
    return false;
  }
  if (recent_.size() < kMaxLate) {
    recent_.push_back(message);
    return true;
  }
  const auto leaves = std::exchange(recent_[oldest_], message);
  oldest_ = (oldest_ + 1) % kMaxLate;
  if (!passed_ || is_after(leaves, *passed_)) passed_ = leaves;
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
