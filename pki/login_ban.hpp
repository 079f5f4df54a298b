// Work during which a process must not log in to a token.
#pragma once

namespace ddssec::pki {

/// While one that applies exists, this process logs in to no token: keys and certificates in tokens
/// fail with pkcs11_not_tried. For work on a folder that another user can change: the owner could
/// name any token of this process, with a wrong PIN, until it locks. Thread-safe.
class LoginBan {
 public:
  explicit LoginBan(bool applies);
  ~LoginBan();
  LoginBan(const LoginBan&) = delete;
  LoginBan& operator=(const LoginBan&) = delete;

 private:
  const bool applies_;
};

}  // namespace ddssec::pki
