// Decides when the plain announcements of a participant's endpoints are read once more.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "base/clock.hpp"
#include "base/ids.hpp"

namespace ddssec::rtps {

/// Where neither discovery nor RTPS messages are protected, anyone can announce in a participant's
/// name that an endpoint has other policies, or has ended. The participant does not notice, and so
/// does not correct it. But its SEDP writers keep what it announced, and send it again to a reader
/// that requests it. If an endpoint has really ended or changed, they keep only its latest
/// announcement.
///
/// An attacker can also make us miss an announcement: by a message with the sequence number that
/// the next one will have, or by a HEARTBEAT or GAP that skips it. Messages that contradict each
/// other count as a change. Not all forgeries are noticed. So everything is also read if there was
/// no refresh for kMaxPause.
///
/// The pause grows, so that a participant with many short-lived endpoints does not send all of them
/// again each time.
///
/// The legal transitions are
///   idle -> due                 note_change, note_end, or kMaxPause after the last refresh
///   due -> being read           begin_refresh_if_due, when the pause is over
///   being read -> idle          end_refresh_if_over, kAnswerTimeout later
///   being read -> due           note_change, note_end: what changes meanwhile is read once more
class AnnouncementRefresh {
 public:
  static constexpr MonotonicTime kMinPause = std::chrono::seconds(4);
  static constexpr MonotonicTime kMaxPause = std::chrono::seconds(256);
  /// How long the answer may take. If it takes longer, everything is read again.
  static constexpr MonotonicTime kAnswerTimeout = std::chrono::seconds(4);
  /// Limit for the endpoints whose end counts before it was read. Their keys are kept.
  static constexpr std::size_t kMaxEnded = 64;
  /// Limit for the endpoints that a refresh did not bring back and whose keys are still
  /// kept: a forged HEARTBEAT can hide an endpoint from a refresh.
  static constexpr std::size_t kMaxGone = 64;
  /// Limit for the endpoints that are remembered as having lost their keys.
  static constexpr std::size_t kMaxWithoutKeys = 1024;

  /// Begins: from now on everything is read at least once in kMaxPause, first within `first`.
  void begin(MonotonicTime now, MonotonicTime first) { routine_ = now + first; }
  /// Notes an unproven message that changes a known endpoint, or contradicts an earlier message.
  void note_change(MonotonicTime now);
  /// Notes an unproven report that an endpoint with keys has ended. Returns true if the endpoint is
  /// treated as ended at once, with its keys kept; false if it stays until the next refresh
  /// decides.
  bool note_end(const EntityId& endpoint, MonotonicTime now);
  /// Notes that a known endpoint is announced: it has not ended.
  void note_alive(const EntityId& endpoint);
  /// Returns true if all announcements are to be read again now.
  bool begin_refresh_if_due(MonotonicTime now);
  /// Returns true once, after the time by which the answer must have arrived.
  bool end_refresh_if_over(MonotonicTime now);
  struct EndedEndpoint {
    EntityId endpoint;
    bool counts;  ///< true if its end counted from the beginning
  };
  /// Ends a refresh that was complete. Returns the endpoints that were said to have ended before
  /// it, and were not announced since while they were known.
  std::vector<EndedEndpoint> take_confirmed_ends();
  /// Notes that the refresh has confirmed the end. Returns the endpoint whose keys are not kept any
  /// longer in exchange: the one that ended first. It is remembered (without_keys).
  std::optional<EntityId> note_gone(const EntityId& endpoint);

  /// True from a request until its answer must have arrived.
  bool is_under_way() const { return over_ != kNever; }
  MonotonicTime due() const { return due_; }
  /// Returns the earliest time at which begin_refresh_if_due or end_refresh_if_over can return
  /// true.
  MonotonicTime next() const;
  /// Returns the endpoints whose keys are not kept, and whether they were requested since.
  std::map<EntityId, bool>& without_keys() { return without_keys_; }

 private:
  struct State {
    bool counts;
    bool is_read = false;  ///< true if a refresh has begun since
  };

  MonotonicTime due_ = kNever, over_ = kNever, routine_ = kNever;
  MonotonicTime last_{};
  MonotonicTime pause_ = kMinPause;
  std::map<EntityId, State> ended_;
  std::size_t counting_ = 0;  ///< the number of those that count
  std::deque<EntityId> gone_;
  std::map<EntityId, bool> without_keys_;
};

}  // namespace ddssec::rtps
