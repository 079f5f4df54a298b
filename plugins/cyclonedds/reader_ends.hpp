// The thread that finds announced local readers that were deleted, and has their ends announced
// (own_readers.hpp). It starts with the first end.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

#include "plugins/cyclonedds/host_entities.hpp"
#include "plugins/cyclonedds/own_readers.hpp"

namespace ddssec::cyclonedds {

/// The reader ends of one domain of the process. Thread-safe.
class ReaderEnds {
 public:
  /// The time from a hint to the check of the host's entities, so that one check finds all that
  /// were deleted together. Also the time until the next check, which must confirm missing readers.
  static constexpr std::chrono::milliseconds kPause{50};
  /// How often to check for readers that are announced later: the host also announces readers that
  /// have already ended to a participant that joins later.
  static constexpr std::chrono::milliseconds kLater{1000};

  using FindHost = std::function<std::unique_ptr<HostEntities>()>;

  explicit ReaderEnds(FindHost find_host) : find_host_(std::move(find_host)) {}
  ~ReaderEnds() { stop(); }
  ReaderEnds(const ReaderEnds&) = delete;
  ReaderEnds& operator=(const ReaderEnds&) = delete;

  OwnReaders& readers() { return readers_; }

  /// Notes that an endpoint of this process may have ended. If the thread cannot be created for
  /// lack of memory, the next hint counts.
  void poll_soon() noexcept;
  /// Stops the thread and returns when it has ended.
  void stop();

  /// Checks the host's entities once. Returns true if something is missing that the next check must
  /// confirm.
  bool poll(const HostEntities& host);

 private:
  void run(const std::stop_token& stop);
  bool wait(const std::stop_token& stop, std::chrono::milliseconds longest);

  const FindHost find_host_;
  OwnReaders readers_;
  /// Readers that were missing at the last check; used by the thread only.
  std::set<Guid> missing_ = {};
  std::mutex mutex_;
  std::condition_variable_any wake_;
  bool is_due_ = false;
  std::jthread thread_;
};

}  // namespace ddssec::cyclonedds
