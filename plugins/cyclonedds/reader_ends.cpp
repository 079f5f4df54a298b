#include "plugins/cyclonedds/reader_ends.hpp"

#include <algorithm>
#include <pthread.h>
#include <utility>

#include "base/background_thread.hpp"

namespace ddssec::cyclonedds {

void ReaderEnds::poll_soon() noexcept {
  try {
    const std::lock_guard lock(mutex_);
    is_due_ = true;
    if (!thread_.joinable()) {
      thread_ = start_background_thread<std::jthread>([this](std::stop_token stop) { run(stop); });
      pthread_setname_np(thread_.native_handle(), "ddssec.ends");
    }
    wake_.notify_one();
  } catch (...) {
    // The next hint tries again.
  }
}

void ReaderEnds::stop() {
  auto thread = [this] {
    const std::lock_guard lock(mutex_);
    return std::exchange(thread_, {});
  }();
  thread.request_stop();
  if (thread.joinable()) thread.join();
}

void ReaderEnds::run(const std::stop_token& stop) {
  const auto host = find_host_();
  if (!host) return;
  std::uint64_t counted = 0;
  bool is_open = false;
  auto pause = kPause;
  while (!stop.stop_requested()) {
    const bool is_hint = wait(stop, is_open ? pause : kLater);
    if (stop.stop_requested()) return;
    const auto count = readers_.count();
    if (!is_hint && !is_open && count == counted) continue;
    counted = count;
    pause = is_hint || !is_open ? kPause : std::min(2 * pause, kLater);
    try {
      is_open = poll(*host);
    } catch (...) {
      is_open = true;  // memory was short, so this checks again
    }
  }
}

bool ReaderEnds::wait(const std::stop_token& stop, std::chrono::milliseconds longest) {
  std::unique_lock lock(mutex_);
  if (!wake_.wait_for(lock, stop, longest, [this] { return is_due_; })) return false;
  is_due_ = false;
  // The wait lets readers that are deleted together be found together.
  wake_.wait_for(lock, stop, kPause, [] { return false; });
  return true;
}

bool ReaderEnds::poll(const HostEntities& host) {
  const auto announced = readers_.announced();
  if (announced.empty()) return false;
  const auto participants = host.participants();
  std::set<Guid> missing;
  for (const auto& reader : announced) {
    const auto owner = std::ranges::find(participants, reader.prefix,
                                         [](const auto& known) { return known.guid.prefix; });
    const bool is_owned = owner != participants.end();
    if (is_owned && owner->entities.contains(reader)) continue;
    // A check may happen between two changes of the host's tables, so a reader must be missing
    // twice.
    if (!missing_.contains(reader)) {
      missing.insert(reader);
    } else if (!is_owned) {
      readers_.forget(reader.prefix);
    } else if (host.carry_end(*owner, reader)) {
      readers_.note_ended(reader);
    } else {
      missing.insert(reader);
    }
  }
  missing_ = std::move(missing);
  return !missing_.empty();
}

}  // namespace ddssec::cyclonedds
