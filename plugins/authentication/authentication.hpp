// The authentication plugin DDS:Auth:PKI-DH (DDS-Security 1.2, clause 10.3), for a host of any
// make.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>

#include "base/plugin_services.hpp"
#include "pki/chain.hpp"
#include "plugins/spi/authentication.hpp"

namespace ddssec::authentication {

/// The options that a host may set.
struct AuthenticationOptions {
  /// The meaning of a missing or outdated revocation list, if one is configured.
  pki::CrlPolicy crl_policy = pki::CrlPolicy::hard_fail;
  /// The largest number of remote identities of each local identity that have authenticated, and
  /// also of those that have not. More are refused until some have left, so that announcements use
  /// up neither memory nor the places of participants that can prove their identity.
  std::size_t max_remote_identities = 10'000;
  /// The largest number of identities of one subject that have authenticated, and never more than
  /// are free. The default is a sixteenth: at most a few hundred participants share a certificate,
  /// and an insider that wants to keep newcomers out needs many certificates.
  std::size_t max_identities_of_a_subject = 625;
  /// The largest number of local identities. Further ones are refused with
  /// too_many_local_identities.
  std::size_t max_local_identities = 256;
};

/// The largest number of handshakes of one pair that were answered or begun and not finished. The
/// oldest one is dropped for a new one when it has waited for kPendingAge. A host that judges
/// handshakes itself returns handles earlier.
inline constexpr std::size_t kMaxPendingPerPair = 40;
inline constexpr std::chrono::seconds kPendingAge{5};

/// Makes the plugin. Every refusal raises one event and changes nothing.
///
/// What a host should know:
/// - An error of begin_handshake_reply or process_handshake is about that one message. The host
///   should drop it, go on waiting and go on sending its own last message. Cyclone DDS forgets its
///   own last message when process_handshake fails, and relies on the peer to send again.
/// - A request that differs from one already answered begins another handshake with its own handle,
///   beside the first (kMaxPendingPerPair). So an attacker that forges a request first does not
///   keep the honest peer out. A final message is tried on each pending handle. Handshakes to which
///   it does not belong refuse it without public-key operations.
/// - The same request gets the same reply, and the same reply the same final message, without new
///   work.
/// - validate_remote_identity for a GUID that this local identity has seen before returns the same
///   handle, whatever the identity token: no token proves anything, and anyone may have announced
///   the first one. A handshake proves who the peer is.
std::unique_ptr<spi::Authentication> make_authentication(const PluginServices& services,
                                                         AuthenticationOptions options = {});

}  // namespace ddssec::authentication
