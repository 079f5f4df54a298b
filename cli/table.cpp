// The table of commands.
#include "cli/groups.hpp"

namespace ddssec::cli {
namespace {

constexpr Option kPassphraseFile{"--passphrase-file", "FILE",
                                 "the CA keys' passphrase (- reads standard input)"};
constexpr Option kPassphraseEnv{"--passphrase-env", "NAME",
                                "the environment variable that holds it"};
constexpr Option kInsecureKeyMode{"--insecure-key-mode", "", "use a CA key that others can read"};
constexpr Option kKey{"--key", "KIND", "p256, rsa2048 or rsa3072", "p256"};

constexpr Option days(std::string_view fallback) {
  return {"--days", "N", "how long it is valid", fallback};
}
constexpr Option ca(std::string_view summary) {
  return {.name = "--ca", .value = "DIR", .summary = summary, .required = true};
}
constexpr Option repeated(std::string_view name, std::string_view value, std::string_view summary) {
  return {.name = name, .value = value, .summary = summary, .repeated = true};
}

const Option kCaCertificate{.name = "--ca",
                            .value = "FILE",
                            .summary = "the permissions CA's certificate",
                            .required = true};

std::vector<Option> signing_options() {
  return {ca("the folder that ca create made"),
          {"-o", "FILE", "the signed document, if not FILE with the ending p7s"},
          kPassphraseFile,
          kPassphraseEnv,
          kInsecureKeyMode};
}

}  // namespace

const std::vector<Option>& common_options() {
  static const std::vector<Option> kOptions = {
      {"--format", "FORM", "text, or one JSON object", "text"},
      {"--now", "TIME", "judge and issue as if it were this time (2026-11-21T00:00:00Z)"},
  };
  return kOptions;
}

const std::vector<Command>& commands() {
  static const std::vector<Command> kCommands = {
      {.group = "ca",
       .name = "create",
       .summary = "Makes an identity CA and a permissions CA, with encrypted keys.",
       .positionals = {{"DIR", "a new folder"}},
       .options = {{"--role", "ROLE", "identity, permissions or both", "both"},
                   {"--subject", "DN", "the CA's name, such as \"CN=Plant CA,O=Example\""},
                   days("3650"),
                   kKey,
                   kPassphraseFile,
                   kPassphraseEnv,
                   {"--no-passphrase", "", "leave the keys unencrypted"}},
       .examples = {"ddssec ca create ca --passphrase-file passphrase.txt",
                    "ddssec ca create test-ca --no-passphrase"},
       .run = ca_create},
      {.group = "ca",
       .name = "show",
       .summary = "Shows a CA's name, validity and how its key is kept.",
       .positionals = {{"DIR", "the folder with ca.pem"}},
       .options = {},
       .examples = {"ddssec ca show ca/identity"},
       .run = ca_show},
      {.group = "identity",
       .name = "issue",
       .summary = "Makes a participant's folder: key, certificate, CA certificates, permissions.",
       .positionals = {{"NAME", "the participant's name"}},
       .options = {ca("the folder that ca create made"),
                   {.name = "-o", .value = "DIR", .summary = "the new folder", .required = true},
                   {"--subject", "DN", "the certificate's name, if not CN=NAME"},
                   days("365"),
                   {"--clamp", "", "end with the CA if it ends before"},
                   kKey,
                   {"--domain", "N", "the domain of the permissions", "0"},
                   repeated("--publish", "TOPIC", "a topic or expression it may publish"),
                   repeated("--subscribe", "TOPIC", "a topic or expression it may subscribe to"),
                   {"--governance", "FILE", "a signed governance document to copy"},
                   kPassphraseFile,
                   kPassphraseEnv,
                   kInsecureKeyMode},
       .examples = {"ddssec identity issue talker --ca ca -o talker --publish rt/chatter "
                    "--governance governance.p7s"},
       .run = identity_issue},
      {.group = "identity",
       .name = "show",
       .summary = "Shows a certificate; exit 1 if it is not valid now.",
       .positionals = {{"PATH", "a participant's folder or a certificate"}},
       .options = {},
       .examples = {"ddssec identity show talker"},
       .run = identity_show},
      {.group = "governance",
       .name = "sign",
       .summary = "Signs a governance document that can be read, in the form every vendor reads.",
       .positionals = {{"FILE", "the XML document"}},
       .options = signing_options(),
       .examples = {"ddssec governance sign governance.xml --ca ca"},
       .run = governance_sign},
      {.group = "governance",
       .name = "verify",
       .summary = "Verifies a signed governance document and reads it.",
       .positionals = {{"FILE", "the signed document"}},
       .options = {kCaCertificate},
       .examples = {"ddssec governance verify governance.p7s --ca ca/permissions/ca.pem"},
       .run = governance_verify},
      {.group = "permissions",
       .name = "sign",
       .summary = "Signs a permissions document that can be read, in the form every vendor reads.",
       .positionals = {{"FILE", "the XML document"}},
       .options = signing_options(),
       .examples = {"ddssec permissions sign permissions.xml --ca ca -o talker/permissions.p7s"},
       .run = permissions_sign},
      {.group = "permissions",
       .name = "verify",
       .summary = "Verifies a signed permissions document and reads it.",
       .positionals = {{"FILE", "the signed document"}},
       .options = {kCaCertificate},
       .examples = {"ddssec permissions verify permissions.p7s --ca ca/permissions/ca.pem"},
       .run = permissions_verify},
      {.group = "",
       .name = "can",
       .summary = "Says whether a participant may use a topic, and which line decides; exit 1: no.",
       .positionals = {{"SUBJECT", "the participant's folder"},
                       {"ACTION", "publish or subscribe"},
                       {"TOPIC", "the topic's name"}},
       .options = {{"--domain", "N", "the domain", "0"},
                   repeated("--partition", "P", "a partition of the endpoint")},
       .examples = {"ddssec can talker publish rt/chatter"},
       .run = can},
      {.group = "",
       .name = "explain",
       .summary = "Says what a code means and what to do about it.",
       .positionals = {{"CODE", "its name or number"}},
       .options = {},
       .examples = {"ddssec explain no_grant_for_subject", "ddssec explain 1242"},
       .run = explain},
  };
  return kCommands;
}

}  // namespace ddssec::cli
