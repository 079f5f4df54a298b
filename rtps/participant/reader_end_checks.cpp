#include "rtps/participant/reader_end_checks.hpp"

#include <algorithm>
#include <utility>

namespace ddssec::rtps {

void ReaderEndChecks::add(const Pair& pair, MonotonicTime now) {
  if (pending_.contains(pair)) return;
  const auto answers = host_.answers(pair);
  if (!answers) return;
  pending_.emplace(pair, PendingCheck{*answers, now, now + kAnswerTimeout});
  next_ = std::min(next_, now);
}

void ReaderEndChecks::tick(MonotonicTime now) {
  if (now < next_) return;
  next_ = kNever;
  // The host may end matches meanwhile, but adds no doubts.
  for (auto at = pending_.begin(); at != pending_.end();) {
    auto& [pair, check] = *at;
    const bool stays = now < check.due || check_answer(pair, check, now);
    if (stays) next_ = std::min(next_, check.due);
    at = stays ? std::next(at) : pending_.erase(at);
  }
}

bool ReaderEndChecks::check_answer(const Pair& pair, PendingCheck& check, MonotonicTime now) {
  const auto answers = host_.answers(pair);
  if (!answers) return false;
  check.is_answered = check.is_answered || *answers != check.answers;
  if (check.is_answered) {
    check.due = check.end;
    return now < check.end;
  }
  if (now >= check.end) {
    if (!std::exchange(check.has_ended, true)) host_.on_no_answer(pair);
    check.interval = std::min(check.interval * 2, kMaxInterval);
  }
  host_.request_sign_of_life(pair);
  check.due = now + check.interval;
  if (!check.has_ended) check.due = std::min(check.due, check.end);
  return true;
}

}  // namespace ddssec::rtps
