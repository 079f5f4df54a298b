// A queue that allocates only if it becomes longer than ever before.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace ddssec::rtps {

/// A first-in, first-out queue. Not thread-safe.
template <class T>
class Ring {
 public:
  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  T& operator[](std::size_t i) { return slots_[place(i)]; }
  const T& operator[](std::size_t i) const { return slots_[place(i)]; }
  T& front() { return slots_[begin_]; }
  const T& front() const { return slots_[begin_]; }

  T& push_back(T value) {
    if (size_ == slots_.size()) grow();
    return slots_[place(size_++)] = std::move(value);
  }
  void pop_front() {
    slots_[begin_] = T{};
    begin_ = place(1);
    --size_;
  }

 private:
  std::size_t place(std::size_t i) const { return (begin_ + i) & (slots_.size() - 1); }
  void grow() {
    std::vector<T> wider(slots_.empty() ? 4 : 2 * slots_.size());
    for (std::size_t i = 0; i < size_; ++i) wider[i] = std::move((*this)[i]);
    slots_.swap(wider);
    begin_ = 0;
  }

  std::vector<T> slots_;  ///< its size is a power of two
  std::size_t begin_ = 0, size_ = 0;
};

}  // namespace ddssec::rtps
