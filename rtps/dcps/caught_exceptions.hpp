// Keeps exceptions from ending the process of the application: memory may be short, and a listener
// may throw.
#pragma once

#include <atomic>
#include <exception>
#include <string_view>

#include "base/event.hpp"

namespace ddssec::rtps {

/// Counts the exceptions of one participant and reports them: on the 1st, 2nd, 4th, 8th ... time.
class CaughtExceptions {
 public:
  /// `events` must outlive this object.
  explicit CaughtExceptions(EventSink& events) : events_(events) {}

  /// Calls `f`. Returns false if an exception ended it. `what` is a text for the event that names
  /// the work that was abandoned.
  template <class F>
  bool run(std::string_view what, F&& f) {
    try {
      f();
      return true;
    } catch (const std::exception& thrown) {
      note(what, thrown.what());
    } catch (...) {
      note(what, "an object that is not a std::exception");
    }
    return false;
  }
  /// Returns the number of exceptions that were caught. Any thread may call it.
  std::uint64_t count() const { return count_; }

 private:
  void note(std::string_view what, const char* thrown) noexcept;

  EventSink& events_;
  std::atomic<std::uint64_t> count_ = 0;
};

}  // namespace ddssec::rtps
