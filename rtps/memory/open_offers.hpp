// The offers that a DescriptorServer answers.
#pragma once

#include <chrono>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/file_descriptor.hpp"
#include "base/secret.hpp"
#include "rtps/memory/memory_refusal.hpp"

namespace ddssec::rtps::memory {

using Token = Secret<struct DescriptorToken, 32>;

/// Thread-safe.
class OpenOffers {
 public:
  static constexpr std::size_t kMax = 64;
  static constexpr std::size_t kMaxOfOne = 16;  ///< for one identity
  static constexpr std::chrono::seconds kLifetime{10};

  struct Offer {
    Token token;
    FileDescriptor descriptor;
    std::uint64_t segment = 0;
    MonotonicTime until{};
    std::string identity = {};  ///< of the peer
  };

  OpenOffers() { offers_.reserve(kMax); }
  /// Error: too_many_tokens.
  MemoryResult<void> add(Offer offer);
  void withdraw(std::uint64_t segment);
  void forget_late(MonotonicTime now);
  /// When the next one is late.
  std::optional<MonotonicTime> next_end() const;
  /// Takes the offer away, so that its token does not work again; an empty descriptor: there is
  /// none. All are compared, so that the time says nothing about them.
  FileDescriptor redeem(const Token& token);
  std::size_t size() const;

 private:
  mutable std::mutex lock_;
  std::vector<Offer> offers_;
};

}  // namespace ddssec::rtps::memory
