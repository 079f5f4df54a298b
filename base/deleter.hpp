// A deleter for objects of C libraries.
#pragma once

namespace ddssec {

/// A deleter of std::unique_ptr that calls the free function of a C library.
template <auto Free>
struct Deleter {
  template <class T>
  void operator()(T* object) const noexcept {
    Free(object);
  }
};

}  // namespace ddssec
