// libddssec_authentication.so
#include "plugins/authentication/authentication.hpp"
#include "plugins/cyclonedds/authentication_adapter.hpp"
#include "plugins/cyclonedds/entry.hpp"
#include "plugins/cyclonedds/expiry_timer.hpp"
#include "plugins/cyclonedds/plugins_in_use.hpp"

using namespace ddssec;
using cyclonedds::AuthenticationAdapter;

DDSSEC_EXPORT int init_authentication(const char*, void** context, ddsi_domaingv* domain) {
  return cyclonedds::init<AuthenticationAdapter, dds_security_authentication>(
      context, domain, __builtin_return_address(0), [](const PluginServices& services) {
        return authentication::make_authentication(services, {});
      });
}

DDSSEC_EXPORT int finalize_authentication(void* context) {
  return cyclonedds::finalize<AuthenticationAdapter, dds_security_authentication>(context);
}

DDSSEC_EXPORT void ddssec_end_sessions_now() { cyclonedds::ExpiryTimer::wake_all(); }

DDSSEC_EXPORT const char* ddssec_authentication_version() { return cyclonedds::version(); }
