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

/// The open offers with their tokens. Thread-safe.
class OpenOffers {
 public:
  static constexpr std::size_t kMax = 64;
  static constexpr std::size_t kMaxOfOne = 16;  ///< the limit for one identity
  static constexpr std::chrono::seconds kLifetime{10};

  struct Offer {
    Token token;
    FileDescriptor descriptor;
    std::uint64_t segment = 0;
    MonotonicTime until{};
    std::string identity = {};  ///< identity of the peer
  };

  OpenOffers() { offers_.reserve(kMax); }
  /// Adds an offer. Error: too_many_tokens.
  MemoryResult<void> add(Offer offer);
  void withdraw(std::uint64_t segment);
  void forget_late(MonotonicTime now);
  /// Returns the time at which the next offer is late.
  std::optional<MonotonicTime> next_end() const;
  /// Removes the offer of this token, so that the token does not work again, and returns its
  /// descriptor. The descriptor is empty if there is no such offer. All tokens are compared, so
  /// that the time reveals nothing about them.
  FileDescriptor redeem(const Token& token);
  std::size_t size() const;

 private:
  mutable std::mutex lock_;
  std::vector<Offer> offers_;
};

}  // namespace ddssec::rtps::memory
