// Whole RTPS messages, whichever participant owns the key. Under a ReadGuard.
#pragma once

#include "plugins/cryptography/receive_key.hpp"
#include "plugins/cryptography/send_key.hpp"
#include "plugins/cryptography/wire.hpp"

namespace ddssec::cryptography {

/// Protects a message without receiver-specific MACs; see spi::CryptoTransform for the buffers and
/// errors. How many octets were written.
Result<std::size_t> seal_message(BytesView plain, Frame frame, SendKey& key, MutableBytes out);

/// The message with INFO_SRC behind its header, if everything about it is right. Nothing of what is
/// not stays in `out`. `prefix_is_network_order`: see Options.
Result<std::size_t> open_message(BytesView encoded, Frame frame, ReceiveKey& key, MutableBytes out,
                                 bool prefix_is_network_order = true);

}  // namespace ddssec::cryptography
