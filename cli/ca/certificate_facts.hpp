// The facts about certificates that results report.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <tuple>

#include <fmt/format.h>

#include "base/bytes.hpp"
#include "cli/frame/fields.hpp"
#include "cli/inputs/times.hpp"
#include "pki/certificate.hpp"

namespace ddssec::cli {

/// A CA's certificate.
struct CaFacts {
  std::string subject, algorithm;
  WallTime not_before, not_after;
  std::string sha256;

  static CaFacts of(const pki::Certificate& ca) {
    return {ca.subject(), std::string(to_string(ca.key_algorithm())), ca.not_before(),
            ca.not_after(), to_hex(ca.fingerprint())};
  }
  static constexpr auto fields() {
    return std::tuple(field<&CaFacts::subject>({.def = "subject"}),
                      field<&CaFacts::algorithm>({.def = "algorithm"}),
                      field<&CaFacts::not_before>(), field<&CaFacts::not_after>(),
                      field<&CaFacts::sha256>({.def = "sha256"}));
  }
};

inline constexpr std::string_view kRoles = "identity|permissions";

/// A CA that was created together with other things.
struct NewCaFacts {
  static constexpr std::string_view kDef = "new_ca";
  std::string role, subject;
  WallTime not_after;
  std::string sha256;

  static NewCaFacts of(std::string_view role, const pki::Certificate& ca) {
    return {std::string(role), ca.subject(), ca.not_after(), to_hex(ca.fingerprint())};
  }
  static constexpr auto fields() {
    return std::tuple(field<&NewCaFacts::role>({.words = kRoles}),
                      field<&NewCaFacts::subject>({.def = "subject"}),
                      field<&NewCaFacts::not_after>(),
                      field<&NewCaFacts::sha256>({.def = "sha256"}));
  }
};

/// A participant's certificate.
struct CertificateFacts {
  std::string subject, serial;
  WallTime not_after;
  std::string sha256;

  static CertificateFacts of(const pki::Certificate& certificate) {
    return {certificate.subject(), certificate.serial(), certificate.not_after(),
            to_hex(certificate.fingerprint())};
  }
  static constexpr auto fields() {
    return std::tuple(field<&CertificateFacts::subject>({.def = "subject"}),
                      field<&CertificateFacts::serial>({.def = "serial"}),
                      field<&CertificateFacts::not_after>(),
                      field<&CertificateFacts::sha256>({.def = "sha256"}));
  }
};

/// A participant whose folder was made.
struct IssuedFacts {
  static constexpr std::string_view kDef = "issued";
  std::string name;
  std::filesystem::path dir;
  CertificateFacts certificate;
  std::string done = {};  ///< empty, or a prefix such as "completed, "

  static constexpr auto fields() {
    return std::tuple_cat(std::tuple(field<&IssuedFacts::name>(), field<&IssuedFacts::dir>()),
                          fields_within(&IssuedFacts::certificate));
  }
  std::string text() const {
    return fmt::format("{}  {}  {}expires {}\n", dir.string(), certificate.subject, done,
                       date(certificate.not_after));
  }
};

}  // namespace ddssec::cli
