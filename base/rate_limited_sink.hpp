// Limits how often events with the same reason are passed on.
#pragma once

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>
#include <unordered_map>

#include "base/clock.hpp"
#include "base/event.hpp"

namespace ddssec {

/// Passes an event on, unless an event with the same reason about the same peer was passed on less
/// than `interval` ago. Lets no exception through: if memory runs out or `next` throws, the event
/// is lost. After `next` threw, an event with the same reason is passed on again after
/// kPauseAfterLoss. Thread-safe.
///
/// The reason consists of the code and the document. The field and the expected value also count if
/// no unauthenticated peer can have chosen them. The found value and names that are only claimed
/// never count, except the found value of an informational notice about the local participant.
///
/// Memory is bounded in shares, so that no peer can suppress events about others. There is one
/// share for the local participant and one for all peers without proof. Each authenticated peer has
/// one share for each code, because it chooses the names of its topics and partitions. If a share
/// is full, or there are more than kMaxRemembered shares of peers, each code is still passed on
/// once in each interval.
class RateLimitedSink final : public EventSink {
 public:
  /// The largest number of reasons about the local participant, and of shares of authenticated
  /// peers.
  static constexpr std::size_t kMaxRemembered = 1024;
  /// Reasons about all unauthenticated peers together.
  static constexpr std::size_t kMaxClaimed = 128;
  /// Reasons about one authenticated peer, for each code.
  static constexpr std::size_t kMaxOfAPeer = 16;
  static constexpr std::chrono::nanoseconds kPauseAfterLoss = std::chrono::seconds(1);

  RateLimitedSink(EventSink& next, const Clock& clock,
                  std::chrono::seconds interval = std::chrono::seconds(10))
      : next_(next), clock_(clock), interval_(interval) {}
  void raise(const Event& event) noexcept override;

 private:
  using Times = std::unordered_map<std::string, std::chrono::nanoseconds>;

  void pass_if_new(const Event& event);
  Times& share_of(const std::string& peer, std::chrono::nanoseconds now);
  bool has_room(Times& share, std::size_t limit, const std::string& reason,
                std::chrono::nanoseconds now) const;
  void pass_if_due(const Event& event, Times& share, const std::string& reason,
                   std::chrono::nanoseconds now);
  void forget_old(Times& share, std::chrono::nanoseconds now) const;

  EventSink& next_;
  const Clock& clock_;
  const std::chrono::nanoseconds interval_;
  std::mutex mutex_;
  Times ours_;
  Times claimed_;
  std::unordered_map<std::string, Times> proven_;  // by code and subject name
  Times no_share_;
  Times crowded_out_;  // by code; there are few
};

}  // namespace ddssec
