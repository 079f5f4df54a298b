// Static objects that outlive every thread.
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <utility>

namespace ddssec {

/// A static object whose destructor never runs. It is needed because a process that calls exit()
/// destroys its static objects while threads of the host and of this library still call the
/// plugins. This type is trivially destructible, so nothing is registered with __cxa_atexit.
template <class T>
class NeverDestroyed {
 public:
  template <class... Arguments>
  explicit NeverDestroyed(Arguments&&... arguments) {
    std::construct_at(place(), std::forward<Arguments>(arguments)...);
  }
  NeverDestroyed(const NeverDestroyed&) = delete;
  NeverDestroyed& operator=(const NeverDestroyed&) = delete;

  T& operator*() { return *std::launder(place()); }
  const T& operator*() const { return *std::launder(place()); }
  T* operator->() { return &**this; }
  const T* operator->() const { return &**this; }

 private:
  T* place() { return static_cast<T*>(static_cast<void*>(octets_)); }
  const T* place() const { return static_cast<const T*>(static_cast<const void*>(octets_)); }

  alignas(T) std::byte octets_[sizeof(T)];
};

}  // namespace ddssec
