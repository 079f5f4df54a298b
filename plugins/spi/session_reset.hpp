// Session reset: a participant that has lost its session with a peer proves that it had one. A peer
// that still has the session then starts a new one. QUIC has the same mechanism under the name
// stateless reset (RFC 9000 10.3).
//
// Both sides derive the tokens from the shared secret while they have it. Each side stores the
// token that the peer would send, to recognize it. It also stores its own token, which outlives the
// session. A token is valid for one session only: a recorded one is useless for the next.
#pragma once

#include <array>
#include <optional>

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "base/result.hpp"
#include "base/secret.hpp"
#include "plugins/spi/shared_secret.hpp"

namespace ddssec::spi {

/// Identifies the session to the receiver. It is not secret, but unpredictable without the shared
/// secret.
using ResetName = std::array<std::uint8_t, 16>;
using ResetProof = Secret<struct ResetProofTag, 32>;

/// What a peer must present to have the session with it ended; secret until it is presented.
struct ResetToken {
  ResetName name{};
  ResetProof proof;
};

/// Returns the token with which the participant with the prefix `sender` resets the session of
/// `shared`. Both parts are HMAC-SHA256 under the shared secret over a label, both challenges and
/// the prefix; the name is the first 16 octets of its HMAC.
ResetToken derive_reset_token(const SharedSecret& shared, const GuidPrefix& sender);

/// Returns a complete RTPS message that carries `token`. It has the form of a protected message
/// (SRTPS_PREFIX, SRTPS_BODY, SRTPS_POSTFIX) with a private CryptoTransformKind. So a host passes
/// it to its cryptography plugin, and every other plugin refuses it.
Bytes write_reset(const GuidPrefix& sender, const ResetToken& token);

/// The parts of a reset message; views into it.
struct Reset {
  BytesView name;   ///< as long as ResetName
  BytesView proof;  ///< 32 octets, not yet compared
};
/// Returns the parts of a reset message; empty for any other message. Compares the size and four
/// octets only, because it is called for every protected message.
std::optional<Reset> read_reset(BytesView message);

}  // namespace ddssec::spi
