// Handles: small values that stand for a plugin's objects at the boundary to a host.
#pragma once

#include <compare>
#include <cstdint>

namespace ddssec::spi {

/// An opaque value; 0 is nil. Handles of different kinds do not convert into one another. A plugin
/// refuses a handle that it never gave out or that was returned, as far as it can detect that.
template <class Tag>
struct Handle {
  std::int64_t value = 0;
  explicit operator bool() const { return value != 0; }
  auto operator<=>(const Handle&) const = default;
};

using IdentityHandle = Handle<struct IdentityHandleTag>;
using HandshakeHandle = Handle<struct HandshakeHandleTag>;
using PermissionsHandle = Handle<struct PermissionsHandleTag>;
using ParticipantCryptoHandle = Handle<struct ParticipantCryptoHandleTag>;
using DatawriterCryptoHandle = Handle<struct DatawriterCryptoHandleTag>;
using DatareaderCryptoHandle = Handle<struct DatareaderCryptoHandleTag>;

}  // namespace ddssec::spi
