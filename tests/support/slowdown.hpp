// The factor by which code may be slower when a sanitizer instruments it.
#pragma once

namespace ddssec::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr int kSlowdown = 10;
#else
inline constexpr int kSlowdown = 1;
#endif

}  // namespace ddssec::test
