// libddssec_access_control.so
#include "plugins/access_control/access_control.hpp"
#include "plugins/cyclonedds/access_control_adapter.hpp"
#include "plugins/cyclonedds/entry.hpp"
#include "plugins/cyclonedds/plugins_in_use.hpp"
#include "plugins/cyclonedds/process_questions.hpp"

using namespace ddssec;
using cyclonedds::AccessControlAdapter;

DDSSEC_EXPORT int init_access_control(const char*, void** context, ddsi_domaingv* domain) {
  return cyclonedds::init<AccessControlAdapter, dds_security_access_control>(
      context, domain, __builtin_return_address(0), [](const PluginServices& services) {
        // A stock authentication plugin presents the permissions with which a participant began.
        return access_control::make_access_control(
            services, {.presents_renewed_permissions = cyclonedds::has_our_authentication});
      });
}

DDSSEC_EXPORT cyclonedds::MatchVerdict ddssec_judge_match_of_peer(
    const cyclonedds::MatchQuestion* question) {
  return AccessControlAdapter::judge(question);
}

DDSSEC_EXPORT void ddssec_cut_off_access_control(DDS_Security_IdentityHandle local) {
  AccessControlAdapter::cut_off({local});
}

DDSSEC_EXPORT std::uint32_t ddssec_governance_facts_of(DDS_Security_IdentityHandle local) {
  return AccessControlAdapter::governance_facts_of({local});
}

DDSSEC_EXPORT std::uint64_t ddssec_renewed_permissions(DDS_Security_IdentityHandle local,
                                                       std::uint64_t known,
                                                       cyclonedds::TakePermissions* take,
                                                       void* context) {
  const auto renewed = AccessControlAdapter::renewed_permissions({local}, known);
  if (!renewed || take == nullptr) return known;
  const auto octets = as_bytes(renewed->text);
  take(context, octets.data(), octets.size());
  return renewed->times;
}

DDSSEC_EXPORT std::uint64_t ddssec_rights_changed(DDS_Security_IdentityHandle local) {
  return AccessControlAdapter::rights_changed({local});
}

DDSSEC_EXPORT void ddssec_return_permissions_of(DDS_Security_IdentityHandle peer) {
  AccessControlAdapter::return_permissions_of({peer});
}

DDSSEC_EXPORT int finalize_access_control(void* context) {
  return cyclonedds::finalize<AccessControlAdapter, dds_security_access_control>(context);
}

DDSSEC_EXPORT const char* ddssec_access_control_version() { return cyclonedds::version(); }
