// The digest by which logs identify a public key.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "pki/certificate.hpp"

namespace ddssec::pki {

/// Returns the SHA-256, in hexadecimal, of the SubjectPublicKeyInfo in its one canonical encoding:
/// the point of an EC key is uncompressed. Two certificates of one key have the same digest,
/// however their requests encoded the key.
std::string key_digest(const Certificate& certificate);

/// All digests that a log may contain for the key of one certificate. Earlier versions of ddssec
/// wrote the digest of the SubjectPublicKeyInfo as encoded in the certificate, so that a compressed
/// point had a different one.
class KeyDigests {
 public:
  explicit KeyDigests(const Certificate& certificate);

  /// Returns the digest that key_digest() returns for the certificate.
  const std::string& canonical() const { return all_.front(); }
  const std::vector<std::string>& all() const { return all_; }
  /// True if `digest` is one of them. False for an empty text, which means that the log does not
  /// contain the key.
  bool contains(std::string_view digest) const;

 private:
  std::vector<std::string> all_;
};

}  // namespace ddssec::pki
