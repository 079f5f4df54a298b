// The local replies to the handshake requests of one peer.
#pragma once

#include "base/clock.hpp"
#include "base/hash.hpp"
#include "plugins/spi/authentication.hpp"
#include "rtps/security/generic_message.hpp"

namespace ddssec::rtps {

/// A reply, and the parts of the request that are needed when the peer's final message arrives.
struct HandshakeAnswer {
  spi::HandshakeHandle handle;
  GenericMessage reply;
  Sha256Digest request;
  Bytes challenge;  ///< challenge1 of the request
  Bytes peer_data;  ///< c.pdata of the request
  MonotonicTime since;
  std::size_t octets = 0;  ///< size of the request, which the plugin keeps until the final message
};

/// The replies to different requests, oldest first. Only one of the requests is honest. An attacker
/// that recorded a certificate can create requests, so the size of the replies to all peers is
/// counted in `account`.
class HandshakeAnswers {
 public:
  static constexpr std::size_t kMax = 32;
  static constexpr std::size_t kMaxPerChallenge = 4;
  /// A younger answer is not removed, so that its final message can arrive in time.
  static constexpr MonotonicTime kMinAge = std::chrono::milliseconds(50);
  /// An older answer does not belong to a current request.
  static constexpr MonotonicTime kLife = std::chrono::seconds(5);
  /// The number of answers that are repeated at once.
  static constexpr std::size_t kMaxRepeated = 4;
  /// The octets that an answer counts in addition to its request.
  static constexpr std::size_t kPrice = 4096;

  /// Both arguments are borrowed and must outlive this object. `account` counts the octets of the
  /// answers to all peers.
  HandshakeAnswers(spi::Authentication& plugin, std::size_t& account)
      : plugin_(plugin), account_(account) {}
  /// The plugin releases the handshakes together with the identity.
  ~HandshakeAnswers() { account_ -= octets_; }
  HandshakeAnswers(const HandshakeAnswers&) = delete;
  HandshakeAnswers& operator=(const HandshakeAnswers&) = delete;

  bool empty() const { return answers_.empty(); }
  std::size_t octets() const { return octets_; }
  const std::vector<HandshakeAnswer>& all() const { return answers_; }
  /// Both functions return nullptr if there is no such answer.
  HandshakeAnswer* to(const Sha256Digest& request);
  HandshakeAnswer* with(spi::HandshakeHandle handle);
  /// Returns the answers whose two challenges `final` repeats.
  std::vector<const HandshakeAnswer*> answered_by(const spi::Authentication::Outline& final) const;

  /// Makes room for an answer to a request with that challenge. Returns false if the others are too
  /// young to be removed.
  bool make_room(const Bytes& challenge, MonotonicTime now);
  const HandshakeAnswer& add(HandshakeAnswer answer);
  /// Removes the answers that are older than kLife.
  void expire(MonotonicTime now);
  /// Removes the oldest answer, if there is one.
  void evict_largest();
  /// Finishes with this answer, whose handshake has succeeded: removes all others.
  void finish(spi::HandshakeHandle handle);
  /// Appends a few answers to `out`, different ones each time.
  void repeat(std::vector<GenericMessage>& out);

 private:
  void forget(std::vector<HandshakeAnswer>::iterator answer);
  void drop(std::vector<HandshakeAnswer>::iterator answer);

  spi::Authentication& plugin_;
  std::size_t& account_;
  std::vector<HandshakeAnswer> answers_;
  std::size_t octets_ = 0;
  std::size_t next_ = 0;  ///< index of the next one to repeat
};

}  // namespace ddssec::rtps
