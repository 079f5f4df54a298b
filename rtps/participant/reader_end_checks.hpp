// Checks remote readers that have ended according to a message that proves nothing.
#pragma once

#include <map>
#include <optional>

#include "base/clock.hpp"
#include "base/ids.hpp"

namespace ddssec::rtps {

/// Where discovery is protected, Cyclone DDS still reports the end of a reader without protection.
/// Anyone can send such a report. So a reliable writer asks the reader, whose answers its keys
/// protect. If no answer comes within kAnswerTimeout, the reader counts as ended. It may only have
/// been out of reach, so it is still asked as long as its participant is there: an attacker who
/// keeps its answers away for a while gains no more than kMaxInterval. Readers of one participant
/// that are silent for long share kMaxQuestions.
///
/// However many reports arrive, a pair is doubted at most once within kAnswerTimeout. No I/O, clock
/// or lock.
class ReaderEndChecks {
 public:
  static constexpr MonotonicTime kAnswerTimeout = std::chrono::seconds(4);
  /// The pause between two queries of a reader until it counts as ended, and the longest one
  /// afterwards.
  static constexpr MonotonicTime kInterval = std::chrono::seconds(1);
  static constexpr MonotonicTime kMaxInterval = std::chrono::seconds(4);
  /// How many pairs with silent readers of one participant are asked in kMaxInterval.
  static constexpr std::size_t kMaxQuestions = 64;

  struct ReaderPair {
    Guid writer, reader;
    auto operator<=>(const ReaderPair&) const = default;
  };
  class Host {
   public:
    virtual ~Host() = default;
    /// Returns how often the reader has answered. Empty if it neither matches nor counts as ended.
    virtual std::optional<std::uint64_t> answers(const ReaderPair& pair) = 0;
    virtual void request_sign_of_life(const ReaderPair& pair) = 0;
    /// Called when the reader counts as ended from now on.
    virtual void on_no_answer(const ReaderPair& pair) = 0;
  };
  /// `host` must outlive this object.
  explicit ReaderEndChecks(Host& host) : host_(host) {}

  /// Begins to doubt the reader. It is asked in the next `tick`.
  void add(const ReaderPair& pair, MonotonicTime now);
  /// Asks all readers for which that is due, and reports those that stayed silent.
  void tick(MonotonicTime now);
  MonotonicTime next() const { return next_; }

 private:
  struct PendingCheck {
    std::uint64_t answers;  ///< the number of answers before
    MonotonicTime due;      ///< when it is asked next
    MonotonicTime end;      ///< the end of kAnswerTimeout
    MonotonicTime interval = kInterval;
    bool is_answered = false, has_ended = false;
  };

  using Pending = std::map<ReaderPair, PendingCheck>;

  /// Returns false if the pair is no longer doubted.
  bool advance(const ReaderPair& pair, PendingCheck& check, MonotonicTime now);
  /// The longest time between two queries to a silent reader of that participant.
  MonotonicTime longest_interval(const GuidPrefix& readers) const;
  Pending::iterator remove(Pending::iterator at);

  Host& host_;
  Pending pending_;
  std::map<GuidPrefix, std::size_t> silent_;  ///< the pairs that have ended, by reader
  MonotonicTime next_ = kNever;               ///< not later than the first that is due
};

}  // namespace ddssec::rtps
