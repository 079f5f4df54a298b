// Gives the descriptors of segments to readers, over a local socket of the writer's process.
//
// An offer is sent to one authenticated peer in a protected message. The peer connects, shows the
// token of the offer, and gets the descriptor. A process that only connects learns nothing.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <poll.h>
#include <sys/types.h>
#include <vector>

#include "rtps/memory/open_offers.hpp"
#include "rtps/memory/segment.hpp"
#include "rtps/memory/untrusted_socket.hpp"

namespace ddssec::rtps::memory {

using SocketName = std::array<std::uint8_t, 16>;

/// The users whose processes may take part, besides those of root.
enum class Users : std::uint8_t { own, any };

/// The facts that a reader needs to fetch and check a descriptor. They are secret, because of the
/// token.
struct DescriptorOffer {
  SocketName name{};          ///< name of the abstract socket
  Token token;                ///< works once
  pid_t process = 0;          ///< the process that must listen
  std::uint64_t segment = 0;  ///< id of the segment
  MemoryId memory = {};       ///< the memory of the descriptor
};

/// The writer's side. Any process of the network namespace may connect, and send anything. A thread
/// of its own must serve it (DescriptorPassing). Not thread-safe, except as stated.
class DescriptorServer {
 public:
  static constexpr std::size_t kMaxConnections = 16;
  /// The largest number of connections of one process, and of one other user than ours.
  static constexpr std::size_t kMaxOfOne = 4;
  static constexpr std::chrono::seconds kSilence{2};  ///< how long a connection may say nothing

  /// Creates a socket with a random name. Error: no_socket.
  static MemoryResult<DescriptorServer> listen(Random& random, Users users = Users::own);
  DescriptorServer(DescriptorServer&&) = default;
  DescriptorServer& operator=(DescriptorServer&& other) noexcept;
  ~DescriptorServer();

  /// Creates an offer of the segment for one peer of this identity. The caller has checked that the
  /// peer has authenticated and may read the topic. May be called while another thread is in
  /// `serve`. Errors: too_many_tokens, no_memory (or /proc is missing), no_socket (no random
  /// octets).
  MemoryResult<DescriptorOffer> offer(const Segment& segment, Random& random, MonotonicTime now,
                                      std::string identity = {});
  /// Returns the offers. May be used while another thread is in `serve`.
  OpenOffers& offers() { return *offers_; }
  const OpenOffers& offers() const { return *offers_; }

  /// Adds the descriptors to wait for.
  void watch(std::vector<pollfd>& out) const;
  /// Returns the time at which `serve` must be called even if nothing arrives.
  std::optional<MonotonicTime> deadline() const;
  void serve(MonotonicTime now);

  std::size_t connections() const { return connections_.size(); }

 private:
  struct Connection {
    UntrustedSocket socket;
    pid_t process = 0;
    uid_t user = 0;
    MonotonicTime until{};
  };
  DescriptorServer() = default;
  void forget_late(MonotonicTime now);
  void accept_waiting(MonotonicTime now);
  void keep(Connection connection);
  bool is_done(const Connection& connection);

  SocketName name_{};
  Users users_ = Users::own;
  FileDescriptor listener_;
  std::unique_ptr<OpenOffers> offers_ = std::make_unique<OpenOffers>();
  std::vector<Connection> connections_;  // oldest first
  std::optional<MonotonicTime> paused_until_;
};

/// The reader's side: one request for the descriptor of an offer. The other side may pass anything,
/// so this, too, needs a thread of its own.
class DescriptorRequest {
 public:
  /// Connects and shows the token, unless another process listens. Errors: no_socket,
  /// wrong_process, other_user, held_up.
  static MemoryResult<DescriptorRequest> send(const DescriptorOffer& offer,
                                              Users users = Users::own);

  /// Returns the socket, which is readable when the answer has arrived.
  int descriptor() const { return socket_.number(); }
  /// Returns the mapped segment, or nothing if the answer has not arrived yet. Errors: no_answer,
  /// those of MappedSegment::map.
  MemoryResult<std::optional<MappedSegment>> take();

 private:
  DescriptorRequest() = default;

  UntrustedSocket socket_;
  std::uint64_t segment_ = 0;
  MemoryId memory_;
};

}  // namespace ddssec::rtps::memory
