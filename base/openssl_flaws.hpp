// Known flaws of the running OpenSSL in functions that ddssec uses.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace ddssec {

/// A flaw that one version of OpenSSL has.
struct OpensslFlaw {
  std::string_view id;       ///< "CVE-2026-45447", or a short name
  std::string_view summary;  ///< one sentence without a full stop
  std::string_view guard;    ///< how ddssec prevents it; empty if only an update helps
  std::string fixed_in;      ///< the first fixed release of the same series, or empty
  /// False if the version number does not prove the flaw: distributions backport fixes without
  /// changing the number.
  bool is_certain = true;
};

/// Returns the flaws of a version, which is written "3.0.19" or as openssl_version() returns it
/// ("OpenSSL 3.0.19 27 Jan 2026"). Uses nothing but the text. Returns nothing for a text without a
/// version, and for a series that is newer than the table.
std::vector<OpensslFlaw> openssl_flaws(std::string_view version);

/// Warns at the start of a process: returns openssl_known_unsafe if at least one flaw is certain.
/// Flaws that are not certain are ignored, because there may be no update that changes the number.
Status check_openssl_flaws(const std::string& version);

}  // namespace ddssec
