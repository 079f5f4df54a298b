#include "secured/start_check.hpp"

#include <utility>

#include "base/event.hpp"
#include "base/plugin_services.hpp"
#include "plugins/authentication/authentication.hpp"
#include "plugins/cryptography/cryptography.hpp"
#include "rtps/security/own_security.hpp"

namespace ddssec::secured {
namespace {

class NoEvents final : public EventSink {
 public:
  void raise(const Event&) override {}
};

}  // namespace

access_control::AccessControlOptions embedded_access_control_options() {
  return {
      .host_revises_keys = true, .host_has_pre_shared_keys = true, .host_changes_protection = true};
}

Status check_start(spi::PropertyList properties, const access_control::AccessControlOptions& host,
                   DomainId domain, WallTime now) {
  const ManualClock clock(now);
  SystemRandom random;
  NoEvents events;
  const PluginServices services{clock, random, events};
  const auto authentication = authentication::make_authentication(services);
  const auto access_control = access_control::make_access_control(services, host);
  const auto cryptography = cryptography::make_cryptography(services);
  DDSSEC_ASSIGN_OR_RETURN(
      const auto own, rtps::OwnSecurity::create({{*authentication, *access_control, *cryptography},
                                                 std::move(properties)},
                                                domain, GuidPrefix{{1}}));
  return {};
}

}  // namespace ddssec::secured
