// The thread that finds which of our announced readers are gone, and has their ends said
// (own_readers.hpp). It runs from the first end on.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

#include "plugins/cyclonedds/host_entities.hpp"
#include "plugins/cyclonedds/own_readers.hpp"

namespace ddssec::cyclonedds {

/// Of one domain of the process. Thread-safe.
class ReaderEnds {
 public:
  /// How long after a hint the host's entities are looked at, so that one look finds what was
  /// deleted together, and how long until the next look must confirm what is missing.
  static constexpr std::chrono::milliseconds kPause{50};
  /// How often readers that are announced later are looked for: the host tells a later
  /// participant of readers that had ended before.
  static constexpr std::chrono::milliseconds kLater{1000};

  using FindHost = std::function<std::unique_ptr<HostEntities>()>;

  explicit ReaderEnds(FindHost find_host) : find_host_(std::move(find_host)) {}
  ~ReaderEnds() { stop(); }
  ReaderEnds(const ReaderEnds&) = delete;
  ReaderEnds& operator=(const ReaderEnds&) = delete;

  OwnReaders& readers() { return readers_; }

  /// An endpoint of this process may have ended. Without memory for the thread, the next hint
  /// counts.
  void look_soon() noexcept;
  /// Returns when the thread has ended.
  void stop();

  /// One look at the host. True: something is missing that the next look must confirm.
  bool look(const HostEntities& host);

 private:
  void run(const std::stop_token& stop);
  bool wait(const std::stop_token& stop, std::chrono::milliseconds longest);

  const FindHost find_host_;
  OwnReaders readers_;
  std::set<Guid> missing_ = {};  ///< by the last look; of the thread
  std::mutex mutex_;
  std::condition_variable_any wake_;
  bool is_due_ = false;
  std::jthread thread_;
};

}  // namespace ddssec::cyclonedds
