#include "cli/key_limits.hpp"

#include <filesystem>

#include "plugins/spi/key_limits.hpp"
#include "plugins/spi/property_file.hpp"

namespace ddssec::cli {
namespace {

namespace doctor = governance::doctor;
using doctor::LoadedFolder;

bool has_properties(const LoadedFolder& folder) {
  std::error_code ignored;
  return std::filesystem::exists(folder.paths.properties, ignored);
}

Result<spi::KeyLimits> limits_of(const LoadedFolder& folder) {
  DDSSEC_ASSIGN_OR_RETURN(const auto file_properties,
                          spi::read_property_file(folder.paths.properties));
  return spi::key_limits(file_properties);
}

bool revises_keys(const LoadedFolder& folder, DomainId domain) {
  const auto* const rule =
      folder.governance.model ? folder.governance.model->find(domain) : nullptr;
  return rule != nullptr && rule->enable_key_revision;
}

}  // namespace

std::optional<Finding> key_limits_obstacle(const LoadedFolder& folder, DomainId domain) {
  if (!has_properties(folder)) return std::nullopt;
  Finding out{.rule = Rule::DOC093, .message = {}, .document = folder.paths.properties.string()};
  const auto limits = limits_of(folder);
  if (!limits) {
    out.message = limits.error().to_sentence();
    out.line = limits.error().details().line;
    return out;
  }
  if (!limits->any() || revises_keys(folder, domain)) return std::nullopt;
  out.message =
      "security.properties limits how long keys are used, and the governance does not set "
      "<enable_key_revision> to true";
  return out;
}

void check_key_limits(const LoadedFolder& folder, const doctor::Settings& settings,
                      doctor::Diagnosis& out) {
  if (!has_properties(folder)) return;
  out.pass(Rule::DOC093);
  if (auto finding = key_limits_obstacle(folder, settings.domain))
    out.report({.ours = doctor::Outcome::fail}, std::move(*finding));
}

}  // namespace ddssec::cli
