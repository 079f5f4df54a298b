// How logs name a public key.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "pki/certificate.hpp"

namespace ddssec::pki {

/// SHA-256 of the SubjectPublicKeyInfo in its one canonical encoding, hexadecimal: the point of an
/// EC key is uncompressed. Two certificates of one key have the same, however their requests wrote
/// the key.
std::string key_digest(const Certificate& certificate);

/// Everything that a log may call the key of one certificate. Earlier versions of ddssec wrote the
/// digest of the SubjectPublicKeyInfo as the certificate has it, so that a compressed point had
/// another one.
class KeyDigests {
 public:
  explicit KeyDigests(const Certificate& certificate);

  /// key_digest().
  const std::string& canonical() const { return all_.front(); }
  const std::vector<std::string>& all() const { return all_; }
  /// False for an empty text, which stands for a key that the log does not name.
  bool contains(std::string_view digest) const;

 private:
  std::vector<std::string> all_;
};

}  // namespace ddssec::pki
