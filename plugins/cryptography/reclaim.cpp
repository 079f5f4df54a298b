#include "plugins/cryptography/reclaim.hpp"

#include <algorithm>

namespace ddssec::cryptography {
namespace {

struct alignas(64) Slot {
  std::atomic<std::uint64_t> epoch = 0;  // 0 outside of a guard
  bool taken = false;                    // guarded by the mutex
};

constinit std::atomic<std::uint64_t> current_epoch = 1;

// The slots of all threads. They are never freed while a thread lives. Slots of ended threads are
// used again.
struct Slots {
  std::mutex mutex;
  std::vector<std::unique_ptr<Slot>> all;
};

Slots& slots() {
  // This object is never freed, because threads may end after static objects are destroyed.
  static Slots& instance = *new Slots;
  return instance;
}

// The slot of the calling thread; nullptr before the first call and after its lease has ended.
constinit thread_local Slot* slot_of_thread = nullptr;
constinit thread_local bool has_lease_ended = false;

Slot* free_slot() {
  auto& shared = slots();
  const std::lock_guard lock(shared.mutex);
  const auto free = std::ranges::find(shared.all, false, [](auto& one) { return one->taken; });
  Slot* const slot = free != shared.all.end()
                         ? free->get()
                         : shared.all.emplace_back(std::make_unique<Slot>()).get();
  slot->taken = true;
  return slot;
}

// The destructor returns the slot when the thread ends.
struct Lease {
  Slot* slot = free_slot();
  Lease() = default;
  ~Lease() {
    slot_of_thread = nullptr;
    has_lease_ended = true;
    const std::lock_guard lock(slots().mutex);
    slot->taken = false;
  }
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;
};

std::atomic<std::uint64_t>& slot_of_this_thread() {
  if (slot_of_thread == nullptr) [[unlikely]] {
    if (has_lease_ended) {
      // exit() ends the leases of its thread first, then calls the host's functions, which may
      // delete participants. The thread keeps this slot.
      slot_of_thread = free_slot();
    } else {
      static thread_local const Lease lease;
      slot_of_thread = lease.slot;
    }
  }
  return slot_of_thread->epoch;
}

std::atomic<std::uint64_t>& enter() {
  auto& slot = slot_of_this_thread();
  slot.exchange(current_epoch.load());
  return slot;
}

}  // namespace

ReadGuard::ReadGuard() : slot_(enter()) {}

std::uint64_t retirement_epoch() noexcept { return current_epoch.fetch_add(1); }

bool is_safe(std::uint64_t epoch) noexcept {
  auto& shared = slots();
  const std::lock_guard lock(shared.mutex);
  return std::ranges::none_of(shared.all, [&](const auto& slot) {
    const auto entered = slot->epoch.load();
    return entered != 0 && entered <= epoch;
  });
}

RetiredObjects::~RetiredObjects() {
  while (first_) first_ = std::move(first_->retired_after_);
}

void RetiredObjects::retire(std::unique_ptr<RetirableObject> object) noexcept {
  if (!object) return;
  {
    const std::lock_guard lock(mutex_);
    object->epoch_ = retirement_epoch();
    auto* const added = object.get();
    (last_ != nullptr ? last_->retired_after_ : first_) = std::move(object);
    last_ = added;
    ++size_;
  }
  // The object is destroyed without the lock, because destructors may retire more objects.
  while (auto dead = take_reclaimable()) {
  }
}

// Stamps increase along the list, so the first object that may still be read keeps all objects
// after it.
std::unique_ptr<RetirableObject> RetiredObjects::take_reclaimable() noexcept {
  const std::lock_guard lock(mutex_);
  if (!first_ || !is_safe(first_->epoch_)) return nullptr;
  auto dead = std::move(first_);
  first_ = std::move(dead->retired_after_);
  if (!first_) last_ = nullptr;
  --size_;
  return dead;
}

std::size_t RetiredObjects::size() const {
  const std::lock_guard lock(mutex_);
  return size_;
}

}  // namespace ddssec::cryptography
