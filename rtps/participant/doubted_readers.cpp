#include "rtps/participant/doubted_readers.hpp"

#include <algorithm>
#include <utility>

namespace ddssec::rtps {

void DoubtedReaders::add(const Pair& pair, MonotonicTime now) {
  if (doubts_.contains(pair)) return;
  const auto answers = host_.answers(pair);
  if (!answers) return;
  doubts_.emplace(pair, Doubt{*answers, now, now + kAnswerTimeout});
  next_ = std::min(next_, now);
}

void DoubtedReaders::tick(MonotonicTime now) {
  if (now < next_) return;
  next_ = kNever;
  // The host may end matches meanwhile, but adds no doubts.
  for (auto at = doubts_.begin(); at != doubts_.end();) {
    auto& [pair, doubt] = *at;
    const bool stays = now < doubt.due || look_at(pair, doubt, now);
    if (stays) next_ = std::min(next_, doubt.due);
    at = stays ? std::next(at) : doubts_.erase(at);
  }
}

bool DoubtedReaders::look_at(const Pair& pair, Doubt& doubt, MonotonicTime now) {
  const auto answers = host_.answers(pair);
  if (!answers) return false;
  doubt.is_answered = doubt.is_answered || *answers != doubt.answers;
  if (doubt.is_answered) {
    doubt.due = doubt.end;
    return now < doubt.end;
  }
  if (now >= doubt.end) {
    if (!std::exchange(doubt.has_ended, true)) host_.on_silent(pair);
    doubt.interval = std::min(doubt.interval * 2, kMaxInterval);
  }
  host_.ask(pair);
  doubt.due = now + doubt.interval;
  if (!doubt.has_ended) doubt.due = std::min(doubt.due, doubt.end);
  return true;
}

}  // namespace ddssec::rtps
