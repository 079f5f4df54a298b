#include "cli/own_start.hpp"

#include <filesystem>
#include <optional>

#include "base/clock.hpp"
#include "base/event.hpp"
#include "plugins/access_control/access_control.hpp"
#include "plugins/authentication/authentication.hpp"
#include "plugins/cryptography/cryptography.hpp"
#include "rtps/security/own_security.hpp"
#include "secured/engines.hpp"

namespace ddssec::cli {
namespace {

namespace doctor = governance::doctor;
using doctor::Outcome;

class StoppedClock final : public Clock {
 public:
  explicit StoppedClock(WallTime now) : now_(now) {}
  WallTime now() const override { return now_; }
  std::chrono::nanoseconds monotonic() const override { return now_.time_since_epoch(); }

 private:
  const WallTime now_;
};

class NoEvents final : public EventSink {
 public:
  void raise(const Event&) override {}
};

Status start(const std::filesystem::path& folder, const doctor::Settings& settings) {
  DDSSEC_ASSIGN_OR_RETURN(auto properties, secured::folder_properties(folder));
  const StoppedClock clock(settings.now);
  SystemRandom random;
  NoEvents events;
  const Environment environment{clock, random, events};
  const auto authentication = authentication::make_authentication(environment);
  const auto access_control =
      access_control::make_access_control(environment, {.host_revises_keys = true,
                                                        .host_has_pre_shared_keys = true,
                                                        .host_changes_protection = true});
  const auto cryptography = cryptography::make_cryptography(environment);
  DDSSEC_ASSIGN_OR_RETURN(
      const auto own, rtps::OwnSecurity::create({{*authentication, *access_control, *cryptography},
                                                 std::move(properties)},
                                                settings.domain, GuidPrefix{{1}}));
  return {};
}

bool starts(const doctor::Diagnosis& diagnosis) {
  return diagnosis.outcomes().of(doctor::Vendor::ours) < Outcome::late;
}

}  // namespace

void check_own_start(const doctor::LoadedFolder& folder, const doctor::Settings& settings,
                     const doctor::Diagnosis& before, doctor::Diagnosis& out) {
  std::error_code ignored;
  if (!std::filesystem::exists(folder.paths.properties, ignored)) return;
  if (!starts(before) || !starts(doctor::diagnose(folder, settings))) return;
  out.pass(Rule::DOC093);
  const auto started = start(folder.paths.folder, settings);
  if (started) return;
  const auto& details = started.error().details();
  out.report(
      {.ours = Outcome::fail},
      {.rule = Rule::DOC093,
       .message = started.error().to_sentence(),
       .document = details.document.empty() ? folder.paths.properties.string() : details.document,
       .line = details.line});
}

}  // namespace ddssec::cli
