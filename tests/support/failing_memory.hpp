// Memory that fails when told to. A program that links this has its operator new replaced and,
// without a sanitizer, malloc and its like; libraries that it loads get these too.
#pragma once

#include <vector>

namespace ddssec::failing_memory {

/// Who asks: C++'s operator new, which throws, or C's malloc and its like, which return null. C's
/// cannot be told to fail under a sanitizer.
enum class Source { cpp, c };
/// One allocation fails, or this and all later ones.
enum class Extent { once, from_then_on };

/// From now on the calling thread's `number`-th allocation (from 1) of `source` fails.
void fail_at(Source source, Extent extent, long number);
/// Allocations succeed again; returns whether any had failed.
bool relent();

/// Blocks of both sources that nobody has freed, in all threads; of operator new alone under a
/// sanitizer, whose own leak check counts the others.
long live_blocks();

/// Whether live_blocks() counts blocks of C's malloc in this build.
bool counts_malloc();

/// Those that can be told to fail in this build.
std::vector<Source> sources();

}  // namespace ddssec::failing_memory
