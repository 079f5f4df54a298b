#include "rtps/reliability/payload.hpp"

#include <array>
#include <bit>
#include <mutex>
#include <new>

#include "base/hash.hpp"

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/asan_interface.h>
#else
#define ASAN_POISON_MEMORY_REGION(begin, size) static_cast<void>(0)
#define ASAN_UNPOISON_MEMORY_REGION(begin, size) static_cast<void>(0)
#endif

namespace ddssec::rtps {
namespace {

// There are four sizes for each power of two, so at most a quarter of a payload is wasted.
constexpr std::size_t kMin = Payload::kMinOctets;
constexpr std::size_t kSteps = 4;

constexpr std::size_t class_of(std::size_t size) {
  if (size <= kMin) return 0;
  const auto doublings = std::bit_width((size - 1) / kMin) - 1u;
  const auto base = kMin << doublings;
  return kSteps * doublings + (size - base + base / kSteps - 1) / (base / kSteps);
}

constexpr std::size_t capacity_of(std::size_t size_class) {
  const auto base = kMin << (size_class / kSteps);
  return base + size_class % kSteps * (base / kSteps);
}

constexpr std::size_t kClasses = class_of(Payload::kMaxKeptOctets) + 1;
static_assert(capacity_of(kClasses - 1) == Payload::kMaxKeptOctets);
static_assert(class_of(65) == 1 && capacity_of(1) == 80 && class_of(80) == 1 && class_of(81) == 2);
static_assert(class_of(128) == 4 && class_of(129) == 5 && capacity_of(4) == 128);

}  // namespace

struct Payload::Store {
  std::mutex mutex;
  std::array<Block*, kClasses> kept{};
  std::size_t octets = 0;  // octets of the blocks that are kept

  Block* take(std::size_t size_class) {
    const std::lock_guard lock(mutex);
    auto* block = kept[size_class];
    if (block == nullptr) return nullptr;
    kept[size_class] = block->next;
    octets -= capacity_of(size_class);
    return block;
  }
  bool keep(Block* block) {
    const std::lock_guard lock(mutex);
    const auto capacity = capacity_of(block->size_class);
    if (octets + capacity > kMaxKept) return false;
    octets += capacity;
    block->next = std::exchange(kept[block->size_class], block);
    return true;
  }
  static constinit Store shared;  // the destructor does nothing, because payloads may outlive main
};
constinit Payload::Store Payload::Store::shared;

Payload Payload::uninitialized(std::size_t size) {
  Payload out;
  if (size == 0) return out;
  const bool kept = size <= kMaxKeptOctets;
  const auto size_class = kept ? class_of(size) : kClasses;
  auto* block = kept ? Store::shared.take(size_class) : nullptr;
  if (block == nullptr)
    block = new (::operator new(sizeof(Block) + kLead + memory_for(size))) Block;
  block->holders.store(1, std::memory_order_relaxed);
  block->size_class = static_cast<std::uint16_t>(size_class);
  block->size = size;
  out.block_ = block;
  ASAN_UNPOISON_MEMORY_REGION(out.octets(), size);
  return out;
}

std::size_t Payload::memory_for(std::size_t size) {
  return size <= kMaxKeptOctets ? capacity_of(class_of(size)) : size;
}

void Payload::release(Block* block) noexcept {
  auto* const octets = octets_of(block);
  if (std::exchange(block->holds_secrets, false)) wipe(MutableBytes(octets, block->size));
  if (block->size_class < kClasses) {
    ASAN_POISON_MEMORY_REGION(octets, capacity_of(block->size_class));
    if (Store::shared.keep(block)) return;
    ASAN_UNPOISON_MEMORY_REGION(octets, capacity_of(block->size_class));
  }
  ::operator delete(block);
}

}  // namespace ddssec::rtps
