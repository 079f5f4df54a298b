// Durable writers whose topics a keeper could not keep because room or a right was missing, and the
// thread that tries again.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "base/ids.hpp"

namespace ddssec::rtps {

/// Tries again, because a writer is announced only once and nothing else would bring its topic
/// back. Thread-safe.
class RefusedWriters {
 public:
  /// The largest number of writers. One identity gets at most as many of these places as are free.
  static constexpr std::size_t kMax = 512;

  /// `again` is called once in each `pause` for each writer, by a thread of its own and without a
  /// lock. It returns false if the writer is refused again.
  explicit RefusedWriters(std::function<bool(const Guid&)> again,
                          std::chrono::milliseconds pause = std::chrono::seconds(1));
  /// Waits until `again` has returned.
  ~RefusedWriters();
  RefusedWriters(const RefusedWriters&) = delete;
  RefusedWriters& operator=(const RefusedWriters&) = delete;

  /// Returns false if the writer already waits.
  bool add(const Guid& writer, const GuidPrefix& identity);
  std::size_t size() const;

 private:
  void run();
  std::vector<Guid> waiting() const;
  void remove(const Guid& writer);
  bool is_stopping() const;

  const std::function<bool(const Guid&)> again_;
  const std::chrono::milliseconds pause_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<Guid, GuidPrefix> writers_;  ///< the writers and their identities
  std::map<GuidPrefix, std::size_t> counts_;
  bool is_stopping_ = false;
  std::thread thread_;
};

}  // namespace ddssec::rtps
