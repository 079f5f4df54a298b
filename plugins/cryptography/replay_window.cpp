#include "plugins/cryptography/replay_window.hpp"

#include <algorithm>
#include <utility>

#include "plugins/cryptography/send_position.hpp"

namespace ddssec::cryptography {
namespace {

/// Sessions of a stream lie this close together; another one's begin at random.
constexpr std::int32_t kMaxDistance = 1 << 16;

/// Numbers count past the greatest one, so their order is the sign of their difference.
bool is_after(std::uint64_t a, std::uint64_t b) { return static_cast<std::int64_t>(a - b) > 0; }

}  // namespace

void ReplayWindow::Stream::begin(std::uint32_t session, std::uint64_t suffix) {
  session_ = session;
  newest_ = suffix;
  passed_.reset();
  recent_.clear();
  recent_.reserve(kMaxLate);
  recent_.push_back(suffix);
  oldest_ = 0;
}

bool ReplayWindow::Stream::accept(std::uint64_t suffix) {
  if (is_after(suffix, newest_)) {
    newest_ = suffix;
  } else if ((passed_ && !is_after(suffix, *passed_)) ||
             std::ranges::find(recent_, suffix) != recent_.end()) {
    return false;
  }
  if (recent_.size() < kMaxLate) {
    recent_.push_back(suffix);
    return true;
  }
  const auto leaves = std::exchange(recent_[oldest_], suffix);
  oldest_ = (oldest_ + 1) % kMaxLate;
  if (!passed_ || is_after(leaves, *passed_)) passed_ = leaves;
  return true;
}

bool ReplayWindow::accept(const Iv& iv) {
  const auto [session, suffix] = parts_of(iv);
  const std::lock_guard lock(mutex_);
  for (auto& stream : streams_) {
    const auto distance = stream.distance(session);
    if (distance == 0) return stream.accept(suffix);
    if (distance < -kMaxDistance || distance > kMaxDistance) continue;
    if (distance < 0) return false;
    stream.begin(session, suffix);
    return true;
  }
  if (streams_.size() >= kMaxStreams) return false;
  streams_.emplace_back(session, suffix);
  return true;
}

}  // namespace ddssec::cryptography
