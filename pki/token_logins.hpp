// Limits how often a process tries PINs.
#pragma once

namespace ddssec::pki {

/// After this call, the first PIN that a token refuses ends all logins of this process, to any
/// token: later ones fail with pkcs11_pin_wrong without an attempt. A program that reads folders of
/// other users calls it, because their files may name PINs, and a card locks after a few wrong
/// ones. Thread-safe.
void stop_at_first_wrong_pin();

/// While one that applies exists, this process logs in to no token: keys and certificates in tokens
/// fail with pkcs11_not_tried. For work on a folder that another user can change: the owner could
/// name any token of this process, with a wrong PIN, until it locks. Thread-safe.
class LoginsForbidden {
 public:
  explicit LoginsForbidden(bool applies);
  ~LoginsForbidden();
  LoginsForbidden(const LoginsForbidden&) = delete;
  LoginsForbidden& operator=(const LoginsForbidden&) = delete;

 private:
  const bool applies_;
};

}  // namespace ddssec::pki
