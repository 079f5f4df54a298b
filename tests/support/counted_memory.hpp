// Counts what operator new does in the program that links counted_memory.
#pragma once

#include <cstdint>

namespace ddssec::counted_memory {

/// Returns the number of calls of operator new so far, of all threads.
std::int64_t allocations();
/// Returns the octets that are allocated now, including what the allocator rounds up.
std::int64_t octets();
/// Returns the octets that were allocated so far, freed or not: the upper bound of what was copied.
std::int64_t octets_ever();

/// Makes one call of operator new in this thread fail: the one that comes after `count` others.
/// With -1, none fails.
void fail_after(std::int64_t count);
/// False if the call that was to fail has not come yet.
bool has_failed();

/// Returns the number of calls of operator new while `f` runs.
template <class F>
std::int64_t allocations_of(F&& f) {
  const auto before = allocations();
  f();
  return allocations() - before;
}

}  // namespace ddssec::counted_memory
