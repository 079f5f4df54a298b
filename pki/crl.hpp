// Certificate revocation lists.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "base/clock.hpp"
#include "base/result.hpp"

namespace ddssec::pki {

/// The largest number of revocation lists in one file.
inline constexpr std::size_t kMostCrlsInFile = 64;

/// An immutable revocation list; copies share it. It counts for nothing until a ChainVerifier has
/// checked who signed it.
class Crl {
 public:
  /// Every list of a file: one DER list, or any number of PEM blocks among others (certificates in
  /// the same file are passed over). The result is empty for a PEM file without a list.
  /// Errors: crl_malformed, crl_too_large.
  static Result<std::vector<Crl>> all_from(BytesView octets);

  /// Issuer name, RFC 2253.
  const std::string& issuer() const;
  WallTime this_update() const;
  /// When a newer one must be there; nothing if the list does not say.
  std::optional<WallTime> next_update() const;
  /// PEM text.
  std::string pem() const;

  struct Impl;
  /// For pki/ only.
  const Impl& impl() const { return *impl_; }
  /// For pki/ only.
  explicit Crl(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}

 private:
  std::shared_ptr<const Impl> impl_;
};

}  // namespace ddssec::pki
