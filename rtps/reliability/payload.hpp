// The octets of a sample, with their encapsulation.
#pragma once

#include <algorithm>
#include <atomic>
#include <utility>

#include "base/bytes.hpp"
#include "rtps/cdr/encapsulation.hpp"

namespace ddssec::rtps {

/// Octets that several holders share and none changes. When the last holder is gone, the memory is
/// kept for the next payload of about that size. All participants of the process share this memory,
/// and it is limited. Once samples flow, a payload costs no allocation. Thread-safe.
class Payload {
 public:
  /// A payload with more octets than this, or one for which kMaxKept leaves no room, is returned to
  /// the allocator at once.
  static constexpr std::size_t kMaxKeptOctets = std::size_t{8} << 20;
  static constexpr std::size_t kMaxKept = std::size_t{32} << 20;
  /// The memory of the smallest payload.
  static constexpr std::size_t kMinOctets = 64;
  /// What follows the encapsulation, in a payload that begins where this class puts it, is aligned
  /// to this.
  static constexpr std::size_t kAlignment = 16;

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
  /// Returns a payload that must be filled before it is shared. Pages that are never written cost
  /// no memory.
  static Payload uninitialized(std::size_t size);
  /// Returns the octets of memory that a payload of this size takes, without its head.
  static std::size_t memory_for(std::size_t size);

  BytesView view() const { return block_ == nullptr ? BytesView{} : BytesView(octets(), size()); }
  MutableBytes fill() {
    return block_ == nullptr ? MutableBytes{} : MutableBytes(octets(), size());
  }
  /// Reduces the payload to its first `size` octets. Call it before it is shared.
  void shrink(std::size_t size) {
    if (block_ != nullptr) block_->size = std::min(size, block_->size);
  }
  std::size_t size() const { return block_ == nullptr ? 0 : block_->size; }
  /// Makes the memory be wiped when the last holder is gone, because the payload contains keys.
  void wipe_at_end() {
    if (block_ != nullptr) block_->holds_secrets = true;
  }

 private:
  struct alignas(kAlignment) Block {
    std::atomic<std::uint32_t> holders = 1;
    std::uint16_t size_class = 0;
    bool holds_secrets = false;
    std::size_t size = 0;
    Block* next = nullptr;  ///< list of the blocks that are kept
  };
  struct Store;
  /// The octets begin this far after the block, so that those after the encapsulation are aligned.
  static constexpr std::size_t kLead = kAlignment - kEncapsulationSize;
  static std::uint8_t* octets_of(Block* block) {
    return static_cast<std::uint8_t*>(static_cast<void*>(block + 1)) + kLead;
  }
  static void release(Block* block) noexcept;
  std::uint8_t* octets() const { return octets_of(block_); }

  Block* block_ = nullptr;
};

}  // namespace ddssec::rtps
