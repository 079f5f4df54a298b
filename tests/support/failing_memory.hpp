// Makes allocations fail on demand. In a program that links this, operator new is replaced and,
// without a sanitizer, malloc and its like; libraries that it loads get these too.
#pragma once

#include <vector>

namespace ddssec::failing_memory {

/// The source of an allocation: C++'s operator new, which throws, or C's malloc and its like, which
/// return null. C's cannot be made to fail under a sanitizer.
enum class Source { cpp, c };
/// The allocations that fail: only one, or this and all later ones.
enum class Extent { once, from_then_on };

/// Makes the calling thread's `number`-th allocation of `source` from now on fail, counted from 1.
void fail_at(Source source, Extent extent, long number);
/// Makes allocations succeed again. Returns true if any had failed.
bool stop_failing();

/// Returns the number of blocks of both sources that are not freed, in all threads. Under a
/// sanitizer, whose own leak check counts the others, it is that of operator new alone.
long live_blocks();

/// True if live_blocks() counts blocks of C's malloc in this build.
bool counts_malloc();

/// Returns the sources that can be made to fail in this build.
std::vector<Source> sources();

}  // namespace ddssec::failing_memory
