#include "plugins/cryptography/fork_generation.hpp"

#include <new>
#include <pthread.h>
#include <sys/mman.h>

namespace ddssec::cryptography {
namespace {

using Place = std::atomic<std::uint64_t>;

constinit Place in_ordinary_memory = 1;

// Returns a page that the kernel fills with zeros in a child; nullptr if this kernel does not
// support it.
Place* wiped_by_kernel() {
#ifdef MADV_WIPEONFORK
  constexpr std::size_t kSize = sizeof(Place);  // a whole page, as all mappings are
  void* const page =
      mmap(nullptr, kSize, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (page == MAP_FAILED) return nullptr;
  if (madvise(page, kSize, MADV_WIPEONFORK) == 0) return new (page) Place(1);
  munmap(page, kSize);
#endif
  return nullptr;
}

// The handler stays valid because the plugins are linked with -z nodelete.
Place* wiped_by_handler() {
  pthread_atfork(nullptr, nullptr, [] { in_ordinary_memory.store(0, std::memory_order_relaxed); });
  return &in_ordinary_memory;
}

}  // namespace

ForkGeneration::ForkGeneration(Detection means)
    : place_(means == Detection::kernel_if_possible ? wiped_by_kernel() : nullptr) {
  if (place_ == nullptr) place_ = wiped_by_handler();
}

ForkGeneration& ForkGeneration::of_process() {
  static ForkGeneration& instance =
      // It is never freed, because threads may outlive static objects.
      *new ForkGeneration(Detection::kernel_if_possible);
  return instance;
}

std::uint64_t ForkGeneration::current() noexcept {
  const auto known = peek();
  if (known != 0) return known;
  std::uint64_t expected = 0;
  const auto next = last_.fetch_add(1) + 1;
  return place_->compare_exchange_strong(expected, next) ? next : expected;
}

}  // namespace ddssec::cryptography
