// Limits how often a process tries PINs.
#pragma once

namespace ddssec::pki {

/// After this call, the first PIN that a token refuses stops all later logins of this process, to
/// any token: they fail with pkcs11_pin_wrong without an attempt. For a program that reads folders
/// of other users, whose files may name PINs: a card locks after a few wrong ones. Thread-safe.
void stop_at_first_wrong_pin();

}  // namespace ddssec::pki
