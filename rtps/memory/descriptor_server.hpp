// Gives the descriptors of segments to readers, over a local socket of the writer's process.
//
// An Offer is sent to one authenticated peer over a protected way. The peer connects, shows the
// token of the offer, and gets the descriptor. A process that only connects learns nothing.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <sys/types.h>
#include <vector>

#include "base/clock.hpp"
#include "base/descriptor.hpp"
#include "base/secret.hpp"
#include "rtps/memory/refusal.hpp"
#include "rtps/memory/segment.hpp"

namespace ddssec::rtps::memory {

using Token = Secret<struct DescriptorToken, 32>;
using SocketName = std::array<std::uint8_t, 16>;

/// What a reader needs to fetch and check a descriptor. Secret, because of the token.
struct Offer {
  SocketName name{};          ///< of the abstract socket
  Token token;                ///< works once
  pid_t process = 0;          ///< which process must listen
  std::uint64_t segment = 0;  ///< id of the segment
  MemoryId memory;            ///< which memory the descriptor must be of
};

/// The writer's side. Never blocks; the caller waits for `descriptor()` to be readable or for
/// `deadline()` to pass, and calls `serve`. Not thread-safe.
class DescriptorServer {
 public:
  static constexpr std::size_t kMaxConnections = 16;
  static constexpr std::size_t kMaxOffers = 64;
  static constexpr std::chrono::seconds kOfferLifetime{10};
  static constexpr std::chrono::seconds kSilence{2};  ///< how long a connection may say nothing

  /// A socket with a random name. Error: no_socket.
  static Outcome<DescriptorServer> listen(Random& random);

  /// An offer of the segment for one peer. The caller has checked that the peer has authenticated
  /// and may read the topic. Errors: too_many_tokens, no_memory, no_socket (no random octets).
  Outcome<Offer> offer(const Segment& segment, Random& random, MonotonicTime now);
  /// No open offer of the segment works any longer, for example because a peer was revoked.
  void withdraw(std::uint64_t segment);

  int descriptor() const { return poll_.number(); }
  /// When `serve` must be called even if nothing arrives.
  std::optional<MonotonicTime> deadline() const;
  void serve(MonotonicTime now);

  std::size_t connections() const { return connections_.size(); }
  std::size_t offers() const { return offers_.size(); }

 private:
  struct Open {
    Token token;
    Descriptor descriptor;
    std::uint64_t segment = 0;
    MonotonicTime until{};
  };
  struct Connection {
    Descriptor socket;
    MonotonicTime until{};
  };
  DescriptorServer() = default;
  void watch_listener(bool on);
  void forget_late(MonotonicTime now);
  void accept_waiting(MonotonicTime now);
  bool is_done(const Connection& connection);
  std::optional<Open> redeem(const Token& token);

  SocketName name_{};
  Descriptor listener_;
  Descriptor poll_;
  std::vector<Open> offers_;
  std::vector<Connection> connections_;  // the oldest first
  std::optional<MonotonicTime> paused_until_;
};

/// The reader's side: one request for the descriptor of an offer. Never blocks.
class DescriptorRequest {
 public:
  /// Connects and shows the token, unless another process listens. Errors: no_socket,
  /// wrong_process.
  static Outcome<DescriptorRequest> send(const Offer& offer);

  /// Readable when the answer is there.
  int descriptor() const { return socket_.number(); }
  /// The mapped segment; nothing if the answer is not there yet. Errors: no_answer, those of
  /// MappedSegment::map.
  Outcome<std::optional<MappedSegment>> take();

 private:
  DescriptorRequest() = default;

  Descriptor socket_;
  std::uint64_t segment_ = 0;
  MemoryId memory_;
};

}  // namespace ddssec::rtps::memory
