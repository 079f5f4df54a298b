// Cyclone's core asks for the same RTPS message once for each local participant that matched its
// sender, and keeps the result of the last call only: every earlier one is memory that nothing
// frees. Here a thread knows the message it opened last, so that one result is made for all.
#pragma once

#include <array>
#include <cstdint>

#include "base/bytes.hpp"
#include "plugins/cyclonedds/abi.hpp"

namespace ddssec::cyclonedds {

/// A protected RTPS message as the core hands it over.
struct MessageCall {
  const void* plugin;  ///< the instance of the domain
  DDS_Security_ParticipantCryptoHandle receiver;
  DDS_Security_ParticipantCryptoHandle sender;
  BytesView octets;
};

/// One for each thread: the core asks for one message in a row, by one thread. Nothing is copied
/// but what the sender's key makes different in any two messages: the CryptoHeader with its IV, and
/// the end, with the tag or the last receiver-specific MAC of it.
class OpenedMessage {
 public:
  static OpenedMessage& of_this_thread() noexcept;

  void forget() noexcept { plugin_ = nullptr; }
  void remember(const MessageCall& call) noexcept;
  /// Is it the remembered one, asked for another local participant? If the same one asks, it is
  /// another datagram of the same content.
  bool was_opened_for_another(const MessageCall& call) const noexcept;

 private:
  /// RTPS header, submessage header and CryptoHeader; common MAC, count and the like.
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
