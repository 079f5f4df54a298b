// Options that several commands share, defined once.
#pragma once

#include <string_view>
#include <vector>

#include "cli/frame/command.hpp"

namespace ddssec::cli {

inline constexpr Option kPassphraseFile{"--passphrase-file", "FILE",
                                        "the CA keys' passphrase (- reads standard input)"};
inline constexpr Option kPassphraseEnv{"--passphrase-env", "NAME",
                                       "the environment variable that holds it"};
inline constexpr Option kPinFile{"--passphrase-file", "FILE",
                                 "the token's PIN (- reads standard input)"};
inline constexpr Option kInsecureKeyMode{"--insecure-key-mode", "",
                                         "use a CA key that others can read"};
inline constexpr Option kNoPassphrase{"--no-passphrase", "", "leave the CA's key unencrypted"};
inline constexpr Option kNextUpdate{"--next-update", "N",
                                    "days until a newer revocation list must be there", "180"};
inline constexpr Option kKey{"--key", "KIND", "p256, rsa2048 or rsa3072", "p256"};
inline constexpr Option kKeyOrToken{
    "--key", "KIND", "p256, rsa2048, rsa3072, or the pkcs11: URI of a key in a token", "p256"};
inline constexpr Option kDomain{"--domain", "N", "the domain", "0"};
inline constexpr Option kDomainToCheck{
    "--domain", "N", "the domain; without it, the one that the documents are for"};
inline constexpr Option kNodeDefaults{
    "--node-defaults", "",
    "add what every rclcpp node of the policy needs to start: rosout, parameter_events and its "
    "parameter services"};

inline constexpr Option kDomains{.name = "--domain",
                                 .value = "N|A-B",
                                 .summary = "a domain or a range of them",
                                 .fallback = "0",
                                 .repeated = true};
inline constexpr Option kOcspResponder{
    "--ocsp-responder", "URL", "an OCSP responder that the certificate names (http://HOST...)"};
inline constexpr Option kClampToCa{"--clamp", "", "end with the CA if it ends before"};
inline constexpr Option kSubject{"--subject", "DN", "the certificate's name, if not CN=NAME"};
inline constexpr Option kSubjectOfFolder{
    "--subject", "DN",
    "the participant, where the CA's log does not have the certificate for this folder"};
inline constexpr Option kOtherGrants{"--other-grants", "",
                                     "with --permissions: sign its grants for other subjects, too"};
inline constexpr Option kReplace{"--replace", "", "put it in place of what is there"};
inline constexpr Option kSign{"--sign", "", "write the signed form (.p7s) beside the document"};
inline constexpr Option kNoRevision{
    "--no-revision", "", "write no revision: participants of the release 0.2.0 refuse it"};
inline constexpr Option kSigningCa{"--ca", "DIR", "the folder that ca create made, for --sign"};

/// Returns these options, followed by those of a command that writes permissions and may sign them.
inline std::vector<Option> with_signing_options(std::vector<Option> options) {
  options.insert(options.end(),
                 {kReplace, kSign, kSigningCa, kPassphraseFile, kPassphraseEnv, kInsecureKeyMode});
  return options;
}

constexpr Option days(std::string_view fallback) {
  return {"--days", "N", "how long it is valid", fallback};
}
constexpr Option ca_option(std::string_view summary) {
  return {.name = "--ca", .value = "DIR", .summary = summary, .required = true};
}
constexpr Option repeated(std::string_view name, std::string_view value, std::string_view summary) {
  return {.name = name, .value = value, .summary = summary, .repeated = true};
}

}  // namespace ddssec::cli
