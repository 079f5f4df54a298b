// The octets of a sample, with their encapsulation.
#pragma once

#include <algorithm>
#include <atomic>
#include <utility>

#include "base/bytes.hpp"

namespace ddssec::rtps {

/// Octets that several holders share and none changes. The memory of the last one to go is kept
/// for the next of about that size, by all participants of the process together and up to a bound:
/// once samples flow, none costs an allocation. Holders may be in any thread.
class Payload {
 public:
  /// Larger ones, and more octets than that, go back to the allocator at once.
  static constexpr std::size_t kLargestKept = std::size_t{8} << 20;
  static constexpr std::size_t kMostKept = std::size_t{32} << 20;

  Payload() = default;
  Payload(const Payload& other) noexcept : block_(other.block_) {
    if (block_ != nullptr) block_->holders.fetch_add(1, std::memory_order_relaxed);
  }
  Payload(Payload&& other) noexcept : block_(std::exchange(other.block_, nullptr)) {}
  Payload& operator=(Payload other) noexcept {
    std::swap(block_, other.block_);
    return *this;
  }
  ~Payload() {
    if (block_ != nullptr && block_->holders.fetch_sub(1, std::memory_order_acq_rel) == 1)
      release(block_);
  }

  static Payload copy_of(BytesView octets) {
    auto out = uninitialized(octets.size());
    std::ranges::copy(octets, out.fill().begin());
    return out;
  }
  /// To be filled in before it is shared; pages that are never written cost no memory.
  static Payload uninitialized(std::size_t size);

  BytesView view() const { return block_ == nullptr ? BytesView{} : BytesView(octets(), size()); }
  MutableBytes fill() {
    return block_ == nullptr ? MutableBytes{} : MutableBytes(octets(), size());
  }
  std::size_t size() const { return block_ == nullptr ? 0 : block_->size; }
  /// Keys are in it: nothing of it stays in memory once the last holder is gone.
  void wipe_at_end() {
    if (block_ != nullptr) block_->holds_secrets = true;
  }

 private:
  struct alignas(16) Block {
    std::atomic<std::uint32_t> holders = 1;
    std::uint16_t size_class = 0;
    bool holds_secrets = false;
    std::size_t size = 0;
    Block* next = nullptr;  ///< of those that are kept
  };
  struct Store;
  static void release(Block* block) noexcept;
  std::uint8_t* octets() const {
    return static_cast<std::uint8_t*>(static_cast<void*>(block_ + 1));
  }

  Block* block_ = nullptr;
};

}  // namespace ddssec::rtps
