// Finds out which HEARTBEATs, ACKNACKs and NACK_FRAGs are repetitions (RTPS 8.4.15.7).
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "rtps/reliability/key_age.hpp"
#include "wire/numbers.hpp"

namespace ddssec::rtps {

/// The messages of one kind from one sender. Their counts increase, so a message whose count is not
/// later than the last one was repeated, by the network or by an attacker.
///
/// That holds for messages that keys of the sender protect, if the protection shows which
/// participant they are for: otherwise they may have been redirected. Without such protection, an
/// attacker can send any count. One that is far ahead would make all later messages of the sender
/// count as repetitions. So an unprotected message is a repetition only if it equals one of the
/// last kRemembered. The attacker gains nothing by repeating older ones, because it could invent
/// new ones. Nor do unprotected messages affect which protected ones are repetitions.
template <class Message>
class RecentMessages {
 public:
  static constexpr std::size_t kRemembered = 2;

  /// Returns false for a repetition. `is_protected` means that keys of the sender protect the
  /// message, and show which participant it is for; `age` is theirs.
  bool accept(const Message& message, bool is_protected, KeyAge age) {
    if (is_protected && age == KeyAge::newest &&
        (!last_newest_ || is_later(message.count, *last_newest_)))
      last_newest_ = message.count;
    const auto& last = is_protected ? last_protected_ : last_;
    const bool is_new = !last || is_later(message.count, *last) ||
                        (!is_protected && std::ranges::find(recent_, message) == recent_.end());
    if (!is_new) return false;
    (is_protected ? last_protected_ : last_) = message.count;
    if (!is_protected) remember(message);
    ++taken_;
    return true;
  }
  /// Restores the last count of a sender that was known before, and that under its newest keys.
  void resume(std::int32_t last, std::optional<std::int32_t> newest = std::nullopt) {
    last_protected_ = last_ = last;
    last_newest_ = newest;
  }
  /// The sender has revised its keys: no message has come under the newest ones.
  void note_revised() { last_newest_.reset(); }
  /// Forgets what did not come under the newest keys.
  void distrust_former_keys() {
    last_protected_ = last_newest_;
    last_.reset();
  }
  /// Returns the highest count under the newest keys, also of messages that were not accepted.
  std::optional<std::int32_t> last_newest() const { return last_newest_; }
  /// Returns the count of the last protected message, or of the last one if none was protected; 0
  /// if there is none.
  std::int32_t last() const { return last_protected_.value_or(last_.value_or(0)); }
  /// Returns the number of messages that were accepted.
  std::uint64_t taken() const { return taken_; }

 private:
  void remember(const Message& message) {
    recent_.reserve(kRemembered);
    if (recent_.size() < kRemembered)
      recent_.push_back(message);
    else
      recent_[taken_ % kRemembered] = message;
  }

  std::optional<std::int32_t> last_protected_, last_, last_newest_;
  std::uint64_t taken_ = 0;
  std::vector<Message> recent_;  ///< unprotected messages
};

}  // namespace ddssec::rtps
