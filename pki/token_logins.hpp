// Limits how often a process tries PINs.
#pragma once

namespace ddssec::pki {

/// After this call, the first PIN that a token refuses ends all logins of this process, to any
/// token: later ones fail with pkcs11_pin_wrong without an attempt. A program that reads folders of
/// other users calls it, because their files may name PINs, and a card locks after a few wrong
/// ones. Thread-safe.
void stop_at_first_wrong_pin();

}  // namespace ddssec::pki
