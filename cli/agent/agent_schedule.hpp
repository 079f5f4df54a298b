// When the agent renews a certificate, and when it tries again after a failure.
#pragma once

#include <chrono>

#include "base/clock.hpp"
#include "pki/certificate.hpp"

namespace ddssec::cli {

/// Returns the time after two thirds of the validity, plus up to a twentieth of it. That part
/// depends on the certificate's octets. Participants of one day are therefore not all renewed at
/// once, and every run of the agent computes the same time.
WallTime renewal_time(const pki::Certificate& certificate);

/// Returns the time from notBefore to notAfter, at least one second.
std::chrono::seconds lifetime(const pki::Certificate& certificate);

/// Returns the wait after so many failures in a row, from 1: about a sixtieth of the lifetime (1 s
/// to 60 s), then twice as long each time, and at most a twelfth of it (2 s to 1 h). `jitter`, a
/// random octet, adds up to an eighth.
std::chrono::seconds retry_after(unsigned failures, std::chrono::seconds lifetime,
                                 std::uint8_t jitter);

/// True for a certificate that begins after `now`: its issuer's clock was ahead. It is renewed at
/// once, although the next one ends earlier.
bool is_from_the_future(const pki::Certificate& certificate, WallTime now);

}  // namespace ddssec::cli
