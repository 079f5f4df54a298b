#include "tests/support/failing_memory.hpp"

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <new>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define DDSSEC_SANITIZED 1
#else
#define DDSSEC_SANITIZED 0
#endif

namespace ddssec::failing_memory {
namespace {

struct Plan {
  Source source = Source::cpp;
  Extent extent = Extent::once;
  long left = 0;  // allocations until the failing one; 0 if none fails
  bool has_failed = false;
};
thread_local constinit Plan plan;
std::atomic<long> live = 0;

// Counts one allocation. True if it is to fail.
bool fails(Source source) {
  if (plan.left == 0 || plan.source != source || --plan.left != 0) return false;
  plan.has_failed = true;
  if (plan.extent == Extent::from_then_on) plan.left = 1;
  return true;
}

template <class Pointer>
Pointer counted(Pointer block) {
  if (block != nullptr) ++live;
  return block;
}

}  // namespace

void fail_at(Source source, Extent extent, long number) { plan = {source, extent, number, false}; }

bool stop_failing() {
  plan.left = 0;
  return plan.has_failed;
}

long live_blocks() { return live; }

bool counts_malloc() { return !DDSSEC_SANITIZED; }

std::vector<Source> sources() {
  if (DDSSEC_SANITIZED) return {Source::cpp};
  return {Source::cpp, Source::c};
}

namespace {

void* allocate(std::size_t size, std::size_t alignment);
void release(void* block);

void* new_block(std::size_t size, std::size_t alignment) {
  if (fails(Source::cpp)) throw std::bad_alloc();
  void* block = allocate(size, alignment);
  if (block == nullptr) throw std::bad_alloc();
  return counted(block);
}

void delete_block(void* block) {
  if (block != nullptr) --live;
  release(block);
}

}  // namespace
}  // namespace ddssec::failing_memory

using namespace ddssec::failing_memory;

void* operator new(std::size_t size) { return new_block(size, 16); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return new_block(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* block) noexcept { delete_block(block); }
void operator delete(void* block, std::size_t) noexcept { delete_block(block); }
void operator delete(void* block, std::align_val_t) noexcept { delete_block(block); }
void operator delete(void* block, std::size_t, std::align_val_t) noexcept { delete_block(block); }

#if DDSSEC_SANITIZED

namespace ddssec::failing_memory {
namespace {

void* allocate(std::size_t size, std::size_t alignment) {
  return std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}
void release(void* block) { std::free(block); }

}  // namespace
}  // namespace ddssec::failing_memory

#else

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

#define DDSSEC_REPLACES __attribute__((visibility("default")))

DDSSEC_REPLACES void* malloc(std::size_t size) noexcept {
  return fails(Source::c) ? nullptr : counted(__libc_malloc(size));
}
DDSSEC_REPLACES void* calloc(std::size_t count, std::size_t size) noexcept {
  return fails(Source::c) ? nullptr : counted(__libc_calloc(count, size));
}
DDSSEC_REPLACES void* realloc(void* block, std::size_t size) noexcept {
  if (fails(Source::c)) return nullptr;
  void* moved = __libc_realloc(block, size);
  if (block == nullptr) return counted(moved);
  if (size == 0) --live;
  return moved;
}
DDSSEC_REPLACES void* memalign(std::size_t alignment, std::size_t size) noexcept {
  return fails(Source::c) ? nullptr : counted(__libc_memalign(alignment, size));
}
DDSSEC_REPLACES void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  return memalign(alignment, size);
}
DDSSEC_REPLACES int posix_memalign(void** block, std::size_t alignment, std::size_t size) noexcept {
  void* const made = memalign(alignment, size);
  if (made == nullptr) return ENOMEM;
  *block = made;
  return 0;
}
DDSSEC_REPLACES void free(void* block) noexcept {
  if (block != nullptr) --live;
  __libc_free(block);
}
}

namespace ddssec::failing_memory {
namespace {

void* allocate(std::size_t size, std::size_t alignment) { return __libc_memalign(alignment, size); }
void release(void* block) { __libc_free(block); }

}  // namespace
}  // namespace ddssec::failing_memory

#endif
