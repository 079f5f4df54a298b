#include "cli/doctor/weakened_protection.hpp"

#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <string_view>

#include <fmt/format.h>

#include "governance/doctor/product.hpp"
#include "plugins/spi/process_properties.hpp"
#include "plugins/spi/property_file.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::cli {
namespace {

namespace doctor = governance::doctor;
namespace fs = std::filesystem;
namespace property = spi::property;

bool is_true(std::string_view value) { return value == "true"; }

bool is_zero(std::string_view value) { return value == "0"; }

bool is_any(std::string_view value) { return !value.empty(); }

// True for a long grace time: an expired certificate counts for this long after the calendar was
// set forward.
bool is_long_grace(std::string_view value) {
  constexpr int kLong = 600;  // seconds
  int seconds = 0;
  const auto read = std::from_chars(value.data(), value.data() + value.size(), seconds);
  return read.ec == std::errc() && seconds > kLong;
}

struct Weakening {
  std::string_view property;
  bool (*is_weak)(std::string_view value);
  std::string_view consequence;
};

constexpr Weakening kWeakenings[] = {
    {property::kAllowSharedMemory, is_true,
     "protected samples pass through shared memory unprotected"},
    {property::kTrustTypeInformation, is_true,
     "each participant of the domain can end this process with forged type information"},
    {property::kFilesPollInterval, is_zero,
     "a revocation list, or permissions with fewer rights, count only from the next start on"},
    {property::kClockStepGrace, is_long_grace,
     "after the clock was set, documents that have ended count for that many seconds more"},
    {property::kTrustedCaDir, is_any,
     "each CA in that folder can make an identity, and no revocation list can be used"},
    {property::kTrustKernel, is_true,
     "payloads are unencrypted in shared memory although messages or submessages are encrypted"},
    {property::kSharedWithOtherUsers, is_true,
     "processes of other users of this machine can share memory with this one"},
};

void diagnose_file(const fs::path& file, doctor::Diagnosis& out) {
  const auto properties = spi::read_property_file(file);
  if (!properties) return;
  for (const auto& weakening : kWeakenings) {
    const auto value = spi::property_value(*properties, weakening.property);
    if (!weakening.is_weak(value)) continue;
    out.report({}, {.rule = Rule::DOC116,
                    .message = fmt::format("{} = {}: {}", weakening.property, value,
                                           weakening.consequence),
                    .document = file.string(),
                    .products = {"ddssec"}});
  }
}

}  // namespace

void diagnose_weakened_protection(const doctor::LoadedFolder& folder, doctor::Diagnosis& out) {
  std::error_code ignored;
  const auto& own = folder.paths.properties;
  if (!own.empty() && fs::exists(own, ignored)) diagnose_file(own, out);
  const char* const file = std::getenv(spi::kPropertiesVariable);
  if (file == nullptr || *file == '\0' || fs::equivalent(file, own, ignored)) return;
  diagnose_file(file, out);
}

}  // namespace ddssec::cli
