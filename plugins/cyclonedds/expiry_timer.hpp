// The thread that revokes expired identities and permissions in the host.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "base/clock.hpp"

namespace ddssec::cyclonedds {

/// Checks once a second, because the clock may be set at any time, or earlier if something expires
/// earlier. It holds no lock while it revokes, because the host takes its entities' locks and calls
/// back into the plugin.
class ExpiryTimer {
 public:
  struct Tasks {
    /// Revokes everything that has just expired, each once, until `stop` is requested.
    std::function<void(const std::stop_token&)> revoke_ended;
    std::function<std::optional<WallTime>()> next_expiry;
  };

  /// The shortest time between two checks, however often it is woken: peers can cause that.
  static constexpr std::chrono::milliseconds kMinPause{50};

  explicit ExpiryTimer(const Clock& clock,
                       std::chrono::milliseconds longest_wait = std::chrono::milliseconds(1000));
  ~ExpiryTimer();
  ExpiryTimer(const ExpiryTimer&) = delete;
  ExpiryTimer& operator=(const ExpiryTimer&) = delete;

  /// Makes all timers of this library check soon (kMinPause), each in its own thread. Any
  /// thread may call it, also while it holds locks of the host.
  static void wake_all() noexcept;

  /// Replaces the tasks of an earlier start.
  void start(Tasks tasks);
  /// Stops the thread and returns when it has ended; afterwards nothing more is called. If it is
  /// called from within a revocation, the thread ends by itself afterwards, and the destructor
  /// waits for it.
  void stop();

 private:
  void run(std::stop_token stop, const Tasks& tasks);
  std::chrono::milliseconds next_wait(const Tasks& tasks) const;

  const Clock& clock_;
  const std::chrono::milliseconds longest_wait_;
  std::mutex control_;  ///< serializes start and stop
  std::mutex sleep_;    ///< guards `is_due_`
  bool is_due_ = false;
  std::condition_variable_any wake_;
  std::jthread thread_;
};

}  // namespace ddssec::cyclonedds
