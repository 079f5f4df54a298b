// Internal to pki/: the private members of certificates, keys and revocation lists.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "base/clock.hpp"
#include "pki/certificate.hpp"
#include "pki/crl.hpp"
#include "pki/key_agreement.hpp"
#include "pki/openssl_pointers.hpp"
#include "pki/private_key.hpp"

namespace ddssec::pki {

struct Certificate::Impl {
  X509Ptr x509;
  Bytes der;
  std::string pem;
  std::string subject;
  std::string subject_one_line;
  std::string issuer;
  Sha256Digest fingerprint;
  Sha256Digest subject_digest;
  WallTime not_before;
  WallTime not_after;
  KeyAlgorithm key;
};

/// Where a private key is.
enum class KeyPlace : std::uint8_t { memory, token };

struct PrivateKey::Impl {
  PkeyPtr pkey;
  KeyAlgorithm algorithm;
  KeyPlace place = KeyPlace::memory;
};

struct Crl::Impl {
  CrlPtr crl;
  std::string issuer;
  WallTime this_update;
  std::optional<WallTime> next_update;
};

struct PeerPublicKey::Impl {
  PkeyPtr pkey;
};

/// Gives pki/ access to the private members of the classes.
struct PkiAccess {
  using CertificateImpl = Certificate::Impl;
  using CrlImpl = Crl::Impl;
  using PrivateKeyImpl = PrivateKey::Impl;
  static const CertificateImpl& of(const Certificate& it) { return *it.impl_; }
  static const CrlImpl& of(const Crl& it) { return *it.impl_; }
  static const PrivateKeyImpl& of(const PrivateKey& it) { return *it.impl_; }
  /// Makes an object that holds `impl`, which must not be nullptr.
  template <class T>
  static T make(std::shared_ptr<const typename T::Impl> impl) {
    return T(std::move(impl));
  }
};
const auto& impl_of(const auto& it) { return PkiAccess::of(it); }

}  // namespace ddssec::pki
