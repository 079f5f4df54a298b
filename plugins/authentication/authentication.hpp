// The authentication plugin DDS:Auth:PKI-DH (DDS-Security 1.2, clause 10.3), for a host of any
// make.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>

#include "base/engine_services.hpp"
#include "pki/chain.hpp"
#include "plugins/spi/authentication.hpp"

namespace ddssec::authentication {

/// What a host may choose.
struct AuthenticationOptions {
  /// What a missing or outdated revocation list means where one is configured.
  pki::CrlPolicy crl_policy = pki::CrlPolicy::hard_fail;
  /// Of each local identity: so many that have authenticated, and as many that have not. More are
  /// refused until some have left, so that announcements use up neither memory nor the room for
  /// those who can prove who they are.
  std::size_t max_remote_identities = 10'000;
  /// How many of those that have authenticated one subject may have, and never more than are free.
  /// A sixteenth: participants that share a certificate are few hundred, and an insider that wants
  /// to keep newcomers out needs many certificates.
  std::size_t max_identities_of_a_subject = 625;
  std::size_t max_local_identities = 256;
};

/// Most handshakes of one pair that were answered or begun and not finished; the oldest gives way
/// when it has waited for kPendingAge. A host with a judgement of its own returns handles earlier.
inline constexpr std::size_t kMaxPendingPerPair = 40;
inline constexpr std::chrono::seconds kPendingAge{5};

/// Every refusal raises one event and changes nothing.
///
/// What a host should know:
/// - An error of begin_handshake_reply or process_handshake is about that one message. The host
///   should drop it, go on waiting and go on sending its own last message; Cyclone DDS forgets its
///   own last message when process_handshake fails, and relies on the peer to send again.
/// - A request different from one already answered begins a handshake of its own, with its own
///   handle, beside the first (kMaxPendingPerPair): an attacker who forges a request first does
///   not keep the honest peer out. A final is tried on each pending handle; those it does not
///   belong to refuse it without public-key work.
/// - The same request gets the same reply, the same reply the same final, without new work.
/// - validate_remote_identity for a GUID that this local identity has seen before returns the same
///   handle. Another identity token replaces the first one as long as no peer authenticated under
///   that GUID (neither token proves anything); afterwards it is refused until
///   return_identity_handle.
std::unique_ptr<spi::Authentication> make_authentication(const EngineServices& services,
                                                         AuthenticationOptions options = {});

}  // namespace ddssec::authentication
