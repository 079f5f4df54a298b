// How often a process tries PINs.
#pragma once

namespace ddssec::pki {

/// From here on the first PIN that a token refuses ends all logins of this process that are not
/// made yet, to any token: they fail with pkcs11_pin_wrong untried. For a program that reads folders
/// of others, whose files may name PINs; a card locks after a few wrong ones. Thread-safe.
void stop_at_first_wrong_pin();

}  // namespace ddssec::pki
