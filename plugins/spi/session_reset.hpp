// A participant that has lost its session with a peer proves that it had one, and so makes a peer
// that has kept it begin anew. RFC 9000 10.3 gives QUIC the same under the name of stateless reset.
//
// Both sides derive the tokens from the shared secret while they have it. Each keeps the token that
// the peer would send, to recognize it, and its own, which outlives the session. A token is good
// for one session: a recorded one means nothing to the next.
#pragma once

#include <array>
#include <optional>

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "base/result.hpp"
#include "base/secret.hpp"
#include "plugins/spi/shared_secret.hpp"

namespace ddssec::spi {

/// By which the receiver finds the session. No secret, but unpredictable without the secret.
using ResetName = std::array<std::uint8_t, 16>;
using ResetProof = Secret<struct ResetProofTag, 32>;

struct ResetToken {
  ResetName name{};
  ResetProof proof;
};

/// The token by which the participant with the prefix `sender` resets the session of `shared`:
/// HMAC-SHA256 under the shared secret, of a label, both challenges and the prefix.
ResetToken derive_reset_token(const SharedSecret& shared, const GuidPrefix& sender);

/// A whole RTPS message. It looks like a protected one (SRTPS_PREFIX, SRTPS_BODY, SRTPS_POSTFIX)
/// whose CryptoTransformKind is ours, so that a host hands it to its cryptography plugin, and every
/// other plugin refuses it.
Bytes write_reset(const GuidPrefix& sender, const ResetToken& token);

/// Views into the message.
struct Reset {
  BytesView name;   ///< as long as ResetName
  BytesView proof;  ///< 32 octets, not yet compared
};
/// Nothing for any other message. Looks at few octets: it is asked about every protected message.
std::optional<Reset> read_reset(BytesView message);

}  // namespace ddssec::spi
