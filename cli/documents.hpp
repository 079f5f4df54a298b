// Signed documents as commands read them.
#pragma once

#include <filesystem>

#include "base/clock.hpp"
#include "pki/smime.hpp"

namespace ddssec::cli {

/// The result; an error gets the path as its document if it had none.
template <class T>
Result<T> named(Result<T> result, const std::filesystem::path& path) {
  if (result) return result;
  return std::unexpected(result.error().in(path));
}

/// The signed document, verified at `now` against the permissions CA file `ca`.
/// Errors: those of read_file, Certificate::bundle_from_pem and DocumentVerifier::verify.
Result<pki::SignedDocument> verified(const std::filesystem::path& file,
                                     const std::filesystem::path& ca, WallTime now);

}  // namespace ddssec::cli
