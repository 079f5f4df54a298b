// Our replies to the handshake requests of one peer.
#pragma once

#include "base/clock.hpp"
#include "base/hash.hpp"
#include "plugins/spi/authentication.hpp"
#include "rtps/security/generic_message.hpp"

namespace ddssec::rtps {

/// A reply of ours, and what of the request is needed when its final comes.
struct HandshakeAnswer {
  spi::HandshakeHandle handle;
  GenericMessage reply;
  Sha256Digest request;
  Bytes challenge;  ///< challenge1 of the request
  Bytes peer_data;  ///< c.pdata of the request
  MonotonicTime since;
  std::size_t octets = 0;  ///< of the request, which the plugin keeps for the final

  /// It repeats both challenges.
  bool is_answered_by(const spi::Token& final) const;
};

/// Answers to different requests, of which one is honest, oldest first. An attacker who recorded a
/// certificate can make requests, so what the answers of all peers take is counted in `account`.
class HandshakeAnswers {
 public:
  static constexpr std::size_t kMax = 32;
  static constexpr std::size_t kMaxPerChallenge = 4;
  /// A younger answer does not give way, so that a final comes in time.
  static constexpr MonotonicTime kMinAge = std::chrono::milliseconds(50);
  /// An older one belongs to no request.
  static constexpr MonotonicTime kLife = std::chrono::seconds(5);
  /// Answers that are repeated at once.
  static constexpr std::size_t kMaxRepeated = 4;
  /// What an answer takes besides its request.
  static constexpr std::size_t kPrice = 4096;

  /// Both are borrowed. `account`: octets of the answers to all peers.
  HandshakeAnswers(spi::Authentication& plugin, std::size_t& account)
      : plugin_(plugin), account_(account) {}
  /// The plugin forgets the handshakes with the identity.
  ~HandshakeAnswers() { account_ -= octets_; }
  HandshakeAnswers(const HandshakeAnswers&) = delete;
  HandshakeAnswers& operator=(const HandshakeAnswers&) = delete;

  bool empty() const { return answers_.empty(); }
  std::size_t octets() const { return octets_; }
  const std::vector<HandshakeAnswer>& all() const { return answers_; }
  /// nullptr: there is none.
  HandshakeAnswer* to(const Sha256Digest& request);
  HandshakeAnswer* with(spi::HandshakeHandle handle);

  /// For an answer to a request with that challenge. False: the others are too young to give way.
  bool make_room(const Bytes& challenge, MonotonicTime now);
  const HandshakeAnswer& add(HandshakeAnswer answer);
  /// Those whose life is over go.
  void expire(MonotonicTime now);
  /// The oldest goes, if there is one.
  void give_way();
  /// The handshake of one of them is finished, and all others go.
  void finish(spi::HandshakeHandle handle);
  /// A few of them go to `out`, others each time.
  void repeat(std::vector<GenericMessage>& out);

 private:
  void forget(std::vector<HandshakeAnswer>::iterator answer);
  void drop(std::vector<HandshakeAnswer>::iterator answer);

  spi::Authentication& plugin_;
  std::size_t& account_;
  std::vector<HandshakeAnswer> answers_;
  std::size_t octets_ = 0;
  std::size_t next_ = 0;  ///< to be repeated
};

}  // namespace ddssec::rtps
