// What the protocol needs of a transport; TCP and shared memory can stand behind it as well as UDP.
#pragma once

#include <span>

#include "base/bytes.hpp"
#include "rtps/wire/locator.hpp"

namespace ddssec::rtps {

class Transport {
 public:
  virtual ~Transport() = default;
  /// Sends one message to each of the locators, at once or not at all: what cannot be sent is lost,
  /// as on any network. `message` is borrowed for the call.
  virtual void send(BytesView message, std::span<const Locator> to) = 0;
};

}  // namespace ddssec::rtps
