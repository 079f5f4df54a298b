// Limits the memory that unauthenticated peers can make the participant allocate: the documents in
// their handshake requests. An attacker can present a recorded certificate under any number of
// invented names.
#pragma once

#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "base/hash.hpp"

namespace ddssec::authentication {

/// The accounts. Thread-safe. Must outlive its shares.
class UnprovenOctets {
 public:
  /// The octets of one peer that are not counted, so that the use by other peers never blocks an
  /// honest request.
  static constexpr std::size_t kFreeOfAPeer = 64 * 1024;
  static constexpr std::size_t kMostOfASubject = 2 * 1024 * 1024;
  static constexpr std::size_t kMost = 16 * 1024 * 1024;

  /// A number of octets; returned at destruction.
  class Share {
   public:
    Share() = default;
    Share(Share&& other) noexcept { swap(other); }
    Share& operator=(Share&& other) noexcept {
      Share taken(std::move(other));
      swap(taken);
      return *this;
    }
    ~Share() {
      if (of_ != nullptr) of_->give_back(subject_, octets_);
    }

    /// The octets of this share that are not counted.
    std::size_t free_octets() const { return of_ == nullptr ? octets_ : 0; }

   private:
    friend UnprovenOctets;
    explicit Share(std::size_t octets) : octets_(octets) {}
    Share(UnprovenOctets& of, const Sha256Digest& subject, std::size_t octets)
        : of_(&of), subject_(subject), octets_(octets) {}
    void swap(Share& other) noexcept {
      std::swap(of_, other.of_);
      std::swap(subject_, other.subject_);
      std::swap(octets_, other.octets_);
    }

    UnprovenOctets* of_ = nullptr;  ///< null: the octets are not counted
    Sha256Digest subject_ = {};
    std::size_t octets_ = 0;
  };

  /// Takes a share of `octets` for a peer whose certificate has that subject. `free_octets`: the
  /// uncounted octets that this peer already holds. Empty if the limit of that subject or of all is
  /// reached.
  std::optional<Share> take(const Sha256Digest& subject, std::size_t octets,
                            std::size_t free_octets);

 private:
  void give_back(const Sha256Digest& subject, std::size_t octets) noexcept;

  std::mutex mutex_;
  std::map<Sha256Digest, std::size_t> by_subject_;
  std::size_t total_ = 0;
};

}  // namespace ddssec::authentication
