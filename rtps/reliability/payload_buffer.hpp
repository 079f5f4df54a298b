// Octets of a sample while it is serialized. They become its payload without a copy.
#pragma once

#include <span>

#include "rtps/reliability/payload.hpp"

namespace ddssec::rtps {

/// Memory that grows while a sample is serialized into it. It has those calls of a vector that
/// CdrWriter needs.
class PayloadBuffer {
 public:
  /// Makes room for `expected` octets. The buffer grows if more are written.
  explicit PayloadBuffer(std::size_t expected);

  std::size_t size() const { return size_; }
  std::uint8_t& operator[](std::size_t at) { return data_[at]; }
  std::uint8_t* end() { return data_ + size_; }
  /// Changes the size. New octets are 0.
  void resize(std::size_t size) {
    if (size > size_) {
      if (size > capacity_) grow(size);
      std::fill(data_ + size_, data_ + size, std::uint8_t{0});
    }
    size_ = size;
  }
  /// Appends the octets from `first` to `last`. A vector has the parameter `at`, too; here it must
  /// be end().
  template <class Iterator>
  void insert([[maybe_unused]] std::uint8_t* at, Iterator first, Iterator last) {
    const auto count = static_cast<std::size_t>(last - first);
    if (count > capacity_ - size_) grow(size_ + count);
    std::copy(first, last, data_ + size_);
    size_ += count;
  }
  void push_back(std::uint8_t octet) {
    if (size_ == capacity_) grow(size_ + 1);
    data_[size_++] = octet;
  }

  /// Returns the payload, which has no more memory than such a payload needs. The buffer may not be
  /// used any more.
  Payload finish() &&;

 private:
  void grow(std::size_t needed);

  Payload payload_;
  std::uint8_t* data_ = nullptr;  ///< that of `payload_`
  std::size_t capacity_ = 0;
  std::size_t size_ = 0;
};

/// Predicts the size of a writer's next sample from its former ones. Thread-safe.
class PayloadSizes {
 public:
  std::size_t expected() const { return expected_.load(std::memory_order_relaxed); }
  /// Notes the size of a sample. After a larger one, the expectation falls slowly.
  void note(std::size_t size) {
    const auto before = expected();
    const auto now = std::max(size, before - before / 16);
    if (now != before) expected_.store(now, std::memory_order_relaxed);
  }

 private:
  std::atomic<std::size_t> expected_ = 0;
};

}  // namespace ddssec::rtps
