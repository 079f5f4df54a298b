#include "tests/support/counted_memory.hpp"

#include <atomic>
#include <cstdlib>
#include <malloc.h>
#include <new>

namespace ddssec::counted_memory {
namespace {

std::atomic<std::int64_t> calls = 0, held = 0, ever = 0;

thread_local std::int64_t until_failure = -1;

// True if this call is to fail.
bool fails() { return until_failure >= 0 && until_failure-- == 0; }

void* counted(void* place) {
  if (place == nullptr) return nullptr;
  const auto size = static_cast<std::int64_t>(malloc_usable_size(place));
  ++calls, held += size, ever += size;
  return place;
}

void* counted_or_throw(void* place) {
  if (place == nullptr) throw std::bad_alloc();
  return counted(place);
}

void release(void* place) noexcept {
  held -= static_cast<std::int64_t>(malloc_usable_size(place));
  std::free(place);
}

}  // namespace

void fail_after(std::int64_t count) { until_failure = count; }
bool has_failed() { return until_failure < 0; }
std::int64_t allocations() { return calls; }
std::int64_t octets() { return held; }
std::int64_t octets_ever() { return ever; }

}  // namespace ddssec::counted_memory

namespace memory = ddssec::counted_memory;

void* operator new(std::size_t size) {
  return memory::counted_or_throw(memory::fails() ? nullptr : std::malloc(size));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return memory::counted(memory::fails() ? nullptr : std::malloc(size));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  const auto unit = static_cast<std::size_t>(alignment);
  const auto whole = (size + unit - 1) / unit * unit;
  return memory::counted_or_throw(memory::fails() ? nullptr : std::aligned_alloc(unit, whole));
}
void operator delete(void* place) noexcept { memory::release(place); }
void operator delete(void* place, std::size_t) noexcept { memory::release(place); }
void operator delete(void* place, std::align_val_t) noexcept { memory::release(place); }
void operator delete(void* place, std::size_t, std::align_val_t) noexcept {
  memory::release(place);
}
