// Counts what operator new does in the program that links counted_memory.
#pragma once

#include <cstdint>

namespace ddssec::counted_memory {

/// Calls of operator new so far, of all threads.
std::int64_t allocations();
/// What they hold now, in octets, with what the allocator rounds up.
std::int64_t octets();
/// What they have held so far, given back or not: how much was copied, at most.
std::int64_t octets_ever();

/// Makes the call of operator new in this thread fail that comes after `count` others, once. -1:
/// none fails.
void fail_after(std::int64_t count);
/// False: the call that was to fail did not come yet.
bool has_failed();

/// Calls of operator new while `f` runs.
template <class F>
std::int64_t allocations_of(F&& f) {
  const auto before = allocations();
  f();
  return allocations() - before;
}

}  // namespace ddssec::counted_memory
