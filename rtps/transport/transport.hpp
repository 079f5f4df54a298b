// The interface that the protocol needs of a transport. UDP implements it; TCP and shared memory
// could.
#pragma once

#include <limits>
#include <span>

#include "base/bytes.hpp"
#include "wire/locator.hpp"

namespace ddssec::rtps {

/// The value of OutgoingMessages::interface with which messages to a group are sent through each
/// interface.
inline constexpr std::size_t kEveryInterface = std::numeric_limits<std::size_t>::max();

/// Messages for the same receivers, borrowed for the call.
struct OutgoingMessages {
  std::span<const BytesView> messages = {};
  std::span<const Locator> to = {};
  std::uint8_t dscp = 0;  ///< differentiated services code point (RFC 2474), 0 to 63
  std::size_t interface = kEveryInterface;  ///< index of the interface for messages to a group
};

/// Sends datagrams. Called by one thread at a time.
class Transport {
 public:
  virtual ~Transport() = default;
  /// Sends each message to each locator, as `send` does.
  virtual void send_all(const OutgoingMessages& out) {
    for (const auto& message : out.messages) send(message, out.to);
  }
  /// Sends one message to each of the locators, at once or not at all: a message that cannot be
  /// sent is lost, as on any network. `message` is borrowed for the call.
  virtual void send(BytesView message, std::span<const Locator> to) = 0;
  /// True if messages to this locator do not leave the machine, so that no link limits their size.
  virtual bool stays_here(const Locator& to) const {
    (void)to;
    return false;
  }
};

}  // namespace ddssec::rtps
