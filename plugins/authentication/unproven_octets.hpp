// Limits the memory that unauthenticated peers can make the participant allocate: the documents in
// their handshake requests. An attacker can present a recorded certificate under any number of
// invented names.
//
// No request is refused because of other ones: the owner of a recorded certificate looks like the
// attacker until its handshake ends. Instead, handshakes that wait for their end are dropped at
// random. To keep the owner out, an attacker must send as much as the limit each time, between our
// reply and the owner's answer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/hash.hpp"
#include "plugins/spi/handles.hpp"

namespace ddssec::authentication {

/// The accounts. Thread-safe. Must outlive its shares.
class UnprovenOctets {
 public:
  /// The octets of one peer that are not counted, so that its handshakes are never dropped to make
  /// room.
  static constexpr std::size_t kFreeOfAPeer = 64 * 1024;
  /// Limit for the peers of one subject: several requests of the largest size that is accepted
  /// (about 1.2 MiB).
  static constexpr std::size_t kMaxOfASubject = 8 * 1024 * 1024;
  static constexpr std::size_t kMax = 16 * 1024 * 1024;

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
      if (of_ != nullptr) of_->release(id_);
    }

    /// Returns the octets of this share that are not counted.
    std::size_t free_octets() const { return of_ == nullptr ? octets_ : 0; }
    /// Names the handshake that holds the octets. Before it is named, the share counts, but is not
    /// dropped.
    void assign_to(spi::HandshakeHandle handshake) const noexcept {
      if (of_ != nullptr) of_->note_owner(id_, handshake);
    }

   private:
    friend UnprovenOctets;
    explicit Share(std::size_t octets) : octets_(octets) {}
    Share(UnprovenOctets& of, std::uint64_t id, std::size_t octets)
        : of_(&of), id_(id), octets_(octets) {}
    void swap(Share& other) noexcept {
      std::swap(of_, other.of_);
      std::swap(id_, other.id_);
      std::swap(octets_, other.octets_);
    }

    UnprovenOctets* of_ = nullptr;  ///< nullptr if the octets are not counted
    std::uint64_t id_ = 0;
    std::size_t octets_ = 0;
  };

  /// Takes a share of `octets` for a peer whose certificate has that subject. `free_octets` is the
  /// number of uncounted octets that this peer already has.
  Share claim(const Sha256Digest& subject, std::size_t octets, std::size_t free_octets);

  /// Returns the handshakes to drop so that the limits hold again, after `newest` got its share.
  /// They are no longer counted. The first ones are of the same subject, the others of any;
  /// `newest` is never among them.
  std::vector<spi::HandshakeHandle> excess(Random& random, spi::HandshakeHandle newest);

 private:
  struct Entry {
    Sha256Digest subject;
    std::size_t octets;
    spi::HandshakeHandle owner = {};
    bool is_counted = true;
  };
  void release(std::uint64_t id) noexcept;
  void note_owner(std::uint64_t id, spi::HandshakeHandle owner) noexcept;
  void uncount(Entry& entry) noexcept;
  Entry* any_of(Random& random, spi::HandshakeHandle newest, const Sha256Digest* subject);

  std::mutex mutex_;
  std::uint64_t last_id_ = 0;
  std::map<std::uint64_t, Entry> entries_;
  std::map<Sha256Digest, std::size_t> by_subject_;
  std::size_t total_ = 0;
};

}  // namespace ddssec::authentication
