// version: which ddssec this is, and which form its JSON has.
#include <fmt/format.h>

#include "cli/groups.hpp"

namespace ddssec::cli {
namespace {

Result<Report> version(const Arguments&, const Context&) {
  return Report{.text = fmt::format("ddssec {}\n", DDSSEC_VERSION),
                .result = {{"version", DDSSEC_VERSION}, {"schema", "ddssec/1"}}};
}

}  // namespace

std::vector<Command> version_commands() {
  return {{.group = "",
           .name = "version",
           .summary = "Prints the version.",
           .positionals = {},
           .options = {},
           .examples = {"ddssec version --format json"},
           .run = version}};
}

}  // namespace ddssec::cli
