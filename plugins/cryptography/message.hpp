// Protection of whole RTPS messages with a given key. All functions run under a ReadGuard.
#pragma once

#include "plugins/cryptography/crypto_framing.hpp"
#include "plugins/cryptography/receive_key.hpp"
#include "plugins/cryptography/send_key.hpp"

namespace ddssec::cryptography {

/// Protects a message without receiver-specific MACs and returns the octets written. See
/// spi::CryptoTransform for buffers and errors.
Result<std::size_t> seal_message(BytesView plain, Frame frame, SendKey& key, MutableBytes out);

/// Verifies a message and returns its octets, with INFO_SRC after the header. After an error
/// nothing decrypted remains in `out`. The header's GUID prefix is in network order.
/// Errors: see spi::CryptoTransform.
Result<std::size_t> open_message(BytesView encoded, Frame frame, ReceiveKey& key, MutableBytes out);

}  // namespace ddssec::cryptography
