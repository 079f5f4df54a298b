// version: the version of ddssec, the schema of its JSON, and known flaws of the running OpenSSL.
#include <fmt/format.h>

#include "base/openssl_flaws.hpp"
#include "base/openssl_version.hpp"
#include "cli/commands/groups.hpp"

namespace ddssec::cli {
namespace {

struct FlawFacts {
  std::string id, summary, fixed_in;
  bool certain;
  std::string guard;

  static constexpr auto fields() {
    return std::tuple(field<&FlawFacts::id>(), field<&FlawFacts::summary>(),
                      field<&FlawFacts::fixed_in>({.note = "empty: no release of the series",
                                                   .pattern = "^([0-9]+\\.[0-9]+\\.[0-9]+)?$"}),
                      field<&FlawFacts::certain>(
                          {"false: the distribution's package of this version may have the fix"}),
                      field<&FlawFacts::guard>({"what ddssec does; empty: only an update helps"}));
  }
  std::string text() const {
    const auto fixed = fixed_in.empty() ? "no release of this series fixes it"
                                        : fmt::format("fixed in OpenSSL {}", fixed_in);
    const auto doubt =
        certain ? "" : ", perhaps also in your distribution's package of this version";
    return fmt::format("  {}: {}; {}{}; {}\n", id, summary, fixed, doubt,
                       guard.empty() ? "ddssec cannot prevent it: update OpenSSL" : guard);
  }
};

struct VersionFacts {
  std::string version, schema, openssl;
  std::vector<FlawFacts> openssl_flaws = {};

  static constexpr auto fields() {
    return std::tuple(field<&VersionFacts::version>({.pattern = "^[0-9]+\\.[0-9]+\\.[0-9]+$"}),
                      field<&VersionFacts::schema>({.words = "ddssec/2"}),
                      field<&VersionFacts::openssl>({"the version that runs"}),
                      field<&VersionFacts::openssl_flaws>({"known flaws of that version"}));
  }
  std::string text() const {
    auto out = fmt::format("ddssec {}\n{}{}\n", version, openssl,
                           openssl_flaws.empty() ? "" : "; known flaws of this version:");
    for (const auto& flaw : openssl_flaws) out += flaw.text();
    return out;
  }
};

Result<Answer<VersionFacts>> version(const Arguments&, const Context&) {
  Answer<VersionFacts> out{{DDSSEC_VERSION, "ddssec/2", openssl_version()}};
  for (const auto& flaw : openssl_flaws(out.result.openssl))
    out.result.openssl_flaws.push_back({std::string(flaw.id), std::string(flaw.summary),
                                        std::string(flaw.fixed_in), flaw.is_certain,
                                        std::string(flaw.guard)});
  return out;
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
