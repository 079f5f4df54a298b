#include "rtps/participant/reader_end_checks.hpp"

#include <algorithm>
#include <utility>

namespace ddssec::rtps {

void ReaderEndChecks::add(const ReaderPair& pair, MonotonicTime now) {
  if (pending_.contains(pair)) return;
  const auto answers = host_.answers(pair);
  if (!answers) return;
  pending_.emplace(pair, PendingCheck{*answers, now, now + kAnswerTimeout});
  next_ = std::min(next_, now);
}

void ReaderEndChecks::tick(MonotonicTime now) {
  if (now < next_) return;
  next_ = kNever;
  // The host's callbacks may end matches, but never call add().
  for (auto at = pending_.begin(); at != pending_.end();) {
    auto& [pair, check] = *at;
    const bool stays = now < check.due || advance(pair, check, now);
    if (stays) next_ = std::min(next_, check.due);
    at = stays ? std::next(at) : remove(at);
  }
}

ReaderEndChecks::Pending::iterator ReaderEndChecks::remove(Pending::iterator at) {
  const auto& [pair, check] = *at;
  const auto& participant = pair.reader.prefix;
  if (check.has_ended && --silent_[participant] == 0) silent_.erase(participant);
  return pending_.erase(at);
}

MonotonicTime ReaderEndChecks::longest_interval(const GuidPrefix& readers) const {
  const auto silent = silent_.find(readers);
  const auto pairs = silent == silent_.end() ? 0 : silent->second;
  return kMaxInterval * (1 + static_cast<std::int64_t>(pairs / kMaxQuestions));
}

bool ReaderEndChecks::advance(const ReaderPair& pair, PendingCheck& check, MonotonicTime now) {
  const auto answers = host_.answers(pair);
  if (!answers) return false;
  check.is_answered = check.is_answered || *answers != check.answers;
  if (check.is_answered) {
    check.due = check.end;
    return now < check.end;
  }
  if (now >= check.end) {
    if (!std::exchange(check.has_ended, true)) {
      ++silent_[pair.reader.prefix];
      host_.on_no_answer(pair);
    }
    check.interval = std::min(check.interval * 2, longest_interval(pair.reader.prefix));
  }
  host_.request_sign_of_life(pair);
  check.due = now + check.interval;
  if (!check.has_ended) check.due = std::min(check.due, check.end);
  return true;
}

}  // namespace ddssec::rtps
