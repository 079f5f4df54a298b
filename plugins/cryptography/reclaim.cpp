#include "plugins/cryptography/reclaim.hpp"

#include <algorithm>

namespace ddssec::cryptography {
namespace {

struct alignas(64) Slot {
  std::atomic<std::uint64_t> epoch = 0;  // 0: outside
  bool taken = false;                    // under the mutex
};

constinit std::atomic<std::uint64_t> current_epoch = 1;

/// All threads' slots. Never freed while a thread lives; slots of dead threads are used again.
struct Slots {
  std::mutex mutex;
  std::vector<std::unique_ptr<Slot>> all;
};

Slots& slots() {
  // Left to the process: threads may end after static objects died.
  static Slots& instance = *new Slots;
  return instance;
}

/// Gives the slot back when the thread ends.
struct Lease {
  Slot* slot;
  Lease() : slot(nullptr) {
    auto& shared = slots();
    const std::lock_guard lock(shared.mutex);
    const auto free = std::ranges::find(shared.all, false, [](auto& one) { return one->taken; });
    slot = free != shared.all.end() ? free->get()
                                    : shared.all.emplace_back(std::make_unique<Slot>()).get();
    slot->taken = true;
  }
  ~Lease() {
    const std::lock_guard lock(slots().mutex);
    slot->taken = false;
  }
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;
};

std::atomic<std::uint64_t>& slot_of_this_thread() {
  static thread_local constinit Slot* mine = nullptr;
  if (mine == nullptr) [[unlikely]] {
    static thread_local const Lease lease;
    mine = lease.slot;
  }
  return mine->epoch;
}

std::atomic<std::uint64_t>& enter() {
  auto& slot = slot_of_this_thread();
  slot.exchange(current_epoch.load());
  return slot;
}

}  // namespace

ReadGuard::ReadGuard() noexcept : slot_(enter()) {}

std::uint64_t retirement_epoch() noexcept { return current_epoch.fetch_add(1); }

bool is_safe(std::uint64_t epoch) noexcept {
  auto& shared = slots();
  const std::lock_guard lock(shared.mutex);
  return std::ranges::none_of(shared.all, [&](const auto& slot) {
    const auto entered = slot->epoch.load();
    return entered != 0 && entered <= epoch;
  });
}

void Graveyard::retire(std::unique_ptr<Retirable> object) {
  const auto epoch = retirement_epoch();
  std::vector<Retired> dead;  // dies without the lock: destructors may retire more
  const std::lock_guard lock(mutex_);
  retired_.push_back({std::move(object), epoch});
  // Stamps only grow along the list, or nearly so: stop at the first that is still read.
  const auto alive =
      std::ranges::find_if_not(retired_, [](const auto& one) { return is_safe(one.epoch); });
  dead.assign(std::make_move_iterator(retired_.begin()), std::make_move_iterator(alive));
  retired_.erase(retired_.begin(), alive);
}

std::size_t Graveyard::size() const {
  const std::lock_guard lock(mutex_);
  return retired_.size();
}

}  // namespace ddssec::cryptography
