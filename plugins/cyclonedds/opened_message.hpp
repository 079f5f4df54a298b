// Remembers the message that a thread decrypted last. Cyclone's core asks for the same RTPS message
// once for each local participant that matched its sender. It keeps the result of the last call
// only, and leaks every earlier one. With this class, one result is made for all.
#pragma once

#include <array>
#include <cstdint>

#include "base/bytes.hpp"
#include "plugins/cyclonedds/abi.hpp"

namespace ddssec::cyclonedds {

/// A protected RTPS message as the core passes it.
struct MessageCall {
  const void* plugin;  ///< the instance of the domain
  DDS_Security_ParticipantCryptoHandle receiver;
  DDS_Security_ParticipantCryptoHandle sender;
  BytesView octets;
};

/// One object for each thread, because one thread of the core makes all calls for one message in a
/// row. Copies only the octets that differ between any two messages of a sender's key: the
/// CryptoHeader with its IV, and the end, with the tag or the last receiver-specific MAC.
class OpenedMessage {
 public:
  static OpenedMessage& of_this_thread() noexcept;

  void forget() noexcept { plugin_ = nullptr; }
  void remember(const MessageCall& call) noexcept;
  /// True if it is the remembered message, for another local participant. If the same participant
  /// asks, it is another datagram with the same content.
  bool was_opened_for_another(const MessageCall& call) const noexcept;

 private:
  /// The size of RTPS header, submessage header and CryptoHeader, and that of common MAC, count and
  /// the like.
  static constexpr std::size_t kHeadSize = 44, kTailSize = 36;

  const void* plugin_ = nullptr;
  DDS_Security_ParticipantCryptoHandle receiver_ = 0;
  DDS_Security_ParticipantCryptoHandle sender_ = 0;
  const std::uint8_t* address_ = nullptr;
  std::size_t size_ = 0;
  std::array<std::uint8_t, kHeadSize> head_{};
  std::array<std::uint8_t, kTailSize> tail_{};
};

}  // namespace ddssec::cyclonedds
