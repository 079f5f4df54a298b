#include "plugins/cyclonedds/refused_creation.hpp"

#include <cstdlib>
#include <utility>

#include "plugins/cyclonedds/host_entities.hpp"

namespace ddssec::cyclonedds {

Status forget_permissions(AccessControlAdapter& adapter, spi::PermissionsHandle permissions) {
  adapter.shared_memory().forget(permissions);
  adapter.facts().forget(permissions);
  adapter.endpoints().forget(permissions);
  adapter.peer_permissions().forget(permissions);
  return adapter.plugin().return_permissions_handle(permissions);
}

void give_up_identity(const dds_security_authentication* authentication,
                      spi::IdentityHandle identity) noexcept {
  if (authentication == nullptr || authentication->return_identity_handle == nullptr) return;
  // The host passes its plugin as const, but the functions of the plugin take it as it is.
  Exception why{};
  authentication->return_identity_handle(const_cast<dds_security_authentication*>(authentication),
                                         identity.value, &why);
  std::free(why.message);
}

Status or_give_up(AccessControlAdapter& adapter, spi::PermissionsHandle permissions,
                  Status status) {
  if (status || status.error().code() == Code::out_of_memory) return status;
  // Permissions that are unknown here belong to no participant that is being created.
  const auto identity = adapter.facts().identity_of(permissions);
  if (!identity) return status;
  static_cast<void>(forget_permissions(adapter, permissions));
  give_up_identity(adapter.authentication(), *identity);
  return status;
}

Status join_or_give_up(AccessControlAdapter& adapter, spi::PermissionsHandle permissions) {
  const auto now = adapter.host().clock().monotonic();
  auto status = adapter.facts().join(permissions, now, false);
  if (!status && !may_have_participants(adapter.host().code(), adapter.domain_id()))
    status = adapter.facts().join(permissions, now, true);
  return or_give_up(adapter, permissions, std::move(status));
}

}  // namespace ddssec::cyclonedds
