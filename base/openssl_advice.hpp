// Which flaws the OpenSSL that runs is known to have in what ddssec uses of it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace ddssec {

/// A flaw that one version of OpenSSL has.
struct OpensslFlaw {
  std::string_view id;       ///< "CVE-2026-45447", or a short name
  std::string_view summary;  ///< a sentence without its full stop
  std::string_view guard;    ///< what ddssec does about it; "" if only an update helps
  std::string fixed_in;  ///< the first release of the same series with the fix; "" if there is none
  /// False where the number does not say: distributions put fixes into a version and keep its
  /// number.
  bool is_certain = true;
};

/// The flaws of a version, written "3.0.19" or as openssl_version() does ("OpenSSL 3.0.19 27 Jan
/// 2026"). A pure function of the text. Empty for a text that names no version, and for a series
/// that is newer than what we know.
std::vector<OpensslFlaw> openssl_flaws(std::string_view version);

/// The warning for the start of a process, with the code openssl_known_unsafe: nothing if no flaw
/// is certain, because then no update may exist that changes the number.
Status openssl_advice(const std::string& version);

}  // namespace ddssec
