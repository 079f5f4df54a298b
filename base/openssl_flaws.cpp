#include "base/openssl_flaws.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

namespace ddssec {
namespace {

struct Version {
  unsigned major = 0, minor = 0, patch = 0;
  auto operator<=>(const Version&) const = default;
};

// A patch number that means that no release of the series has the fix.
constexpr unsigned kNotFixed = 0;

struct Row {
  std::string_view id, summary, guard;
  // The first release with the fix, for each series. 0.0.0 means unused.
  std::array<Version, 8> fixes;
};

// The flaws come from OpenSSL's advisories (https://openssl-library.org/news/vulnerabilities/).
// Only flaws that input of ddssec can reach are listed, so none in TLS, PKCS#12 or CMS encryption.
// No flaw in OCSP (pki/ocsp.cpp) is listed: the only one, CVE-2022-1343 in OpenSSL before 3.0.3,
// needs a flag that ddssec does not use.
constexpr std::array kRows = {
    Row{.id = "CVE-2023-0286",
        .summary = "a revocation list or certificate with an X.400 address can read invalid memory",
        .guard = "",
        .fixes = {{{3, 0, 8}}}},
    Row{.id = "CVE-2023-2650",
        .summary = "a huge object identifier in a certificate keeps the processor busy for minutes",
        .guard = "",
        .fixes = {{{3, 0, 9}, {3, 1, 1}}}},
    Row{.id = "CVE-2026-22796",
        .summary = "PKCS7_verify reads a messageDigest of a wrong type as invalid memory",
        .guard = "ddssec refuses such a signature itself (code 1174)",
        .fixes = {{{3, 0, 19},
                   {3, 1, kNotFixed},
                   {3, 2, kNotFixed},
                   {3, 3, 6},
                   {3, 4, 4},
                   {3, 5, 5},
                   {3, 6, 1}}}},
    Row{.id = "CVE-2026-45447",
        .summary =
            "PKCS7_verify frees memory of its caller if a signature lists no digest algorithm",
        .guard = "ddssec refuses such a signature itself (code 1173)",
        .fixes = {{{3, 0, 21},
                   {3, 1, kNotFixed},
                   {3, 2, kNotFixed},
                   {3, 3, kNotFixed},
                   {3, 4, 6},
                   {3, 5, 7},
                   {3, 6, 3},
                   {4, 0, 1}}}},
    // This is OpenSSL's change 31044, which has no CVE. The flaw was seen with Debian's 3.0.17,
    // 3.0.19 and 3.0.20, but not with 3.0.22.
    Row{.id = "delta-crl-as-complete",
        .summary =
            "a delta revocation list counts as a complete one, so that a revoked certificate "
            "can be accepted",
        .guard = "ddssec refuses delta lists itself (code 1158)",
        .fixes = {{{3, 0, 22},
                   {3, 1, kNotFixed},
                   {3, 2, kNotFixed},
                   {3, 3, kNotFixed},
                   {3, 4, 7},
                   {3, 5, 8},
                   {3, 6, 4},
                   {4, 0, 2}}}},
    Row{.id = "CVE-2026-35189",
        .summary = "a certificate of 64 KiB can take hundreds of MiB of memory",
        .guard = "ddssec refuses such a certificate itself (code 1115)",
        .fixes = {{{3, 0, 23},
                   {3, 1, kNotFixed},
                   {3, 2, kNotFixed},
                   {3, 3, kNotFixed},
                   {3, 4, 8},
                   {3, 5, 9},
                   {3, 6, 5},
                   {4, 0, 3}}}},
};

// Ubuntu 22.04 and 24.04 backport every fix into these versions.
constexpr std::array kKeptNumbers = {Version{3, 0, 2}, Version{3, 0, 13}};

std::optional<Version> parse(std::string_view text) {
  const auto first = text.find_first_of("0123456789");
  if (first == text.npos) return std::nullopt;
  text.remove_prefix(first);
  Version out;
  const auto read_number = [&](unsigned& to) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), to);
    if (error != std::errc()) return false;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return true;
  };
  const auto read_dot_and_number = [&](unsigned& to) {
    if (!text.starts_with('.')) return false;
    text.remove_prefix(1);
    return read_number(to);
  };
  if (!read_number(out.major) || !read_dot_and_number(out.minor) || !read_dot_and_number(out.patch))
    return std::nullopt;
  return out;
}

std::string to_text(const Version& version) {
  return std::to_string(version.major) + "." + std::to_string(version.minor) + "." +
         std::to_string(version.patch);
}

// True if the version number proves the flaw. It often does not, because a distribution's security
// update can contain the fix under the previous number: Debian 12 has the fixes of 3.0.19, 3.0.21
// and 3.0.23 in 3.0.18-1~deb12u2, 3.0.20-1~deb12u2 and 3.0.22-1~deb12u2.
bool is_proven_by_number(const Version& version, const Version& fix) {
  return (fix.patch == kNotFixed || version.patch + 1 < fix.patch) &&
         std::ranges::find(kKeptNumbers, version) == kKeptNumbers.end();
}

std::optional<OpensslFlaw> judge(const Row& row, const Version& version) {
  const auto fix = std::ranges::find_if(row.fixes, [&](const Version& it) {
    return it.major == version.major && it.minor == version.minor && it.major != 0;
  });
  if (fix == row.fixes.end()) return std::nullopt;
  if (fix->patch != kNotFixed && version >= *fix) return std::nullopt;
  return OpensslFlaw{row.id, row.summary, row.guard,
                     fix->patch == kNotFixed ? std::string() : to_text(*fix),
                     is_proven_by_number(version, *fix)};
}

// Returns "OpenSSL 3.0.19" for "OpenSSL 3.0.19 27 Jan 2026".
std::string without_date(const std::string& version) {
  const auto name = version.find(' ');
  return name == version.npos ? version : version.substr(0, version.find(' ', name + 1));
}

// Says of which flaws ddssec prevents the use.
std::string guards_in_words(const std::vector<OpensslFlaw>& flaws) {
  std::string open;
  std::size_t count = 0;
  for (const auto& flaw : flaws) {
    if (!flaw.guard.empty()) continue;
    if (count++ > 0) open += ", ";
    open += flaw.id;
  }
  if (count == 0) return "ddssec refuses the input that uses them";
  const auto only = "only an update helps against " + open;
  return count == flaws.size() ? only : only + "; ddssec refuses the input that uses the others";
}

}  // namespace

std::vector<OpensslFlaw> openssl_flaws(std::string_view version) {
  std::vector<OpensslFlaw> out;
  const auto parsed = parse(version);
  if (!parsed) return out;
  for (const auto& row : kRows)
    if (auto flaw = judge(row, *parsed)) out.push_back(*std::move(flaw));
  return out;
}

Status check_openssl_flaws(const std::string& version) {
  auto flaws = openssl_flaws(version);
  std::erase_if(flaws, [](const OpensslFlaw& flaw) { return !flaw.is_certain; });
  if (flaws.empty()) return {};
  return fail(Code::openssl_known_unsafe,
              {.found = without_date(version),
               .note = guards_in_words(flaws),
               .hint = "update its package; ddssec explain 1624 says more"});
}

}  // namespace ddssec
