#include "rtps/memory/outside_descriptor.hpp"

#include <array>
#include <mutex>
#include <thread>

#include "base/background_thread.hpp"

namespace ddssec::rtps::memory {
namespace {

constexpr std::size_t kMostWaiting = 64;
constexpr std::size_t kTooMany = 8;

struct Closer {
  std::mutex lock;
  std::array<int, kMostWaiting> waiting{};
  std::size_t count = 0;
  bool runs = false;
};

// Never destroyed: its thread may outlast main.
Closer& closer() {
  static auto* const out = new Closer;
  return *out;
}

void close_all() {
  auto& all = closer();
  for (std::unique_lock held(all.lock);; held.lock()) {
    if (all.count == 0) {
      all.runs = false;
      return;
    }
    const int number = all.waiting[--all.count];
    held.unlock();
    ::close(number);
  }
}

}  // namespace

void close_elsewhere(Descriptor descriptor) {
  auto& all = closer();
  const std::lock_guard held(all.lock);
  const int number = descriptor.release();
  if (number < 0 || all.count == kMostWaiting) return;
  all.waiting[all.count++] = number;
  if (all.runs) return;
  start_background_thread<std::thread>(close_all).detach();
  all.runs = true;
}

bool closes_too_many() {
  auto& all = closer();
  const std::lock_guard held(all.lock);
  return all.count >= kTooMany;
}

}  // namespace ddssec::rtps::memory
