// Keeps the events that the code under test raises.
#pragma once

#include <algorithm>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/event.hpp"

namespace ddssec::test {

/// Events may arrive from any thread. The functions lock `mutex`; lock it to use `all` while other
/// threads may raise events.
struct RecordedEvents final : EventSink {
  void raise(const Event& event) override {
    const std::scoped_lock lock(mutex);
    all.push_back(event);
  }

  std::vector<Code> codes() const {
    const std::scoped_lock lock(mutex);
    std::vector<Code> out;
    for (const auto& event : all) out.push_back(event.error.code());
    return out;
  }
  int count(Code code) const { return static_cast<int>(std::ranges::count(codes(), code)); }
  bool has(Code code) const { return count(code) > 0; }
  /// Returns the code of the one event since the last call; empty if there were more, or none.
  std::optional<Code> only() {
    const std::scoped_lock lock(mutex);
    const auto events = std::exchange(all, {});
    return events.size() == 1 ? std::optional(events.front().error.code()) : std::nullopt;
  }
  /// True if all events are about peers that authenticated.
  bool is_quiet() const {
    return std::ranges::all_of(codes(), [](Code c) { return c == Code::rtps_peer_authenticated; });
  }
  /// Returns the sentence of the last event; empty if there was none.
  std::string last() const {
    const std::scoped_lock lock(mutex);
    return all.empty() ? std::string() : all.back().error.to_sentence();
  }
  /// Returns all events, one line each.
  std::string text() const {
    const std::scoped_lock lock(mutex);
    std::string out;
    for (const auto& event : all) out += event.to_line() + "\n";
    return out;
  }

  mutable std::mutex mutex;
  std::vector<Event> all;
};

}  // namespace ddssec::test
