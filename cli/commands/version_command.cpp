// version: the version of ddssec, the schema of its JSON, and known flaws of the running OpenSSL.
#include <fmt/format.h>

#include "base/openssl_advice.hpp"
#include "base/openssl_version.hpp"
#include "cli/commands/groups.hpp"

namespace ddssec::cli {
namespace {

std::string text_of(const OpensslFlaw& flaw) {
  const auto fixed = flaw.fixed_in.empty() ? "no release of this series fixes it"
                                           : fmt::format("fixed in OpenSSL {}", flaw.fixed_in);
  const auto doubt =
      flaw.is_certain ? "" : ", perhaps also in your distribution's package of this version";
  return fmt::format("  {}: {}; {}{}; {}\n", flaw.id, flaw.summary, fixed, doubt,
                     flaw.guard.empty() ? "ddssec cannot prevent it: update OpenSSL" : flaw.guard);
}

Json json_of(const OpensslFlaw& flaw) {
  return {{"id", flaw.id},
          {"summary", flaw.summary},
          {"fixed_in", flaw.fixed_in},
          {"certain", flaw.is_certain},
          {"guard", flaw.guard}};
}

Result<Report> version(const Arguments&, const Context&) {
  const auto openssl = openssl_version();
  const auto flaws = openssl_flaws(openssl);
  std::string listed;
  Json of_flaws = Json::array();
  for (const auto& flaw : flaws) {
    listed += text_of(flaw);
    of_flaws.push_back(json_of(flaw));
  }
  return Report{.text = fmt::format("ddssec {}\n{}{}\n{}", DDSSEC_VERSION, openssl,
                                    flaws.empty() ? "" : "; known flaws of this version:", listed),
                .result = {{"version", DDSSEC_VERSION},
                           {"schema", "ddssec/1"},
                           {"openssl", openssl},
                           {"openssl_flaws", of_flaws}}};
}

}  // namespace

std::vector<Command> version_commands() {
  return {{.group = "",
           .name = "version",
           .summary = "Prints the version, and the known flaws of the OpenSSL in use.",
           .positionals = {},
           .options = {},
           .examples = {"ddssec version --format json"},
           .run = version}};
}

}  // namespace ddssec::cli
