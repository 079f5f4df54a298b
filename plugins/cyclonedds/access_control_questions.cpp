// Answers to the questions of the other two ddssec libraries in the process (abi.hpp).
#include <cstdlib>
#include <map>
#include <mutex>
#include <shared_mutex>

#include "plugins/cyclonedds/access_control_adapter.hpp"
#include "plugins/cyclonedds/endpoint_scope.hpp"

namespace ddssec::cyclonedds {
namespace {

// The adapters in the process, one for each domain.
struct Adapters {
  std::shared_mutex mutex;
  std::map<std::uint64_t, AccessControlAdapter*> by_id;
};

// The object is never destroyed, because a thread of the host may ask while the process exits.
Adapters& adapters() {
  static auto* const all = new Adapters;
  return *all;
}

MatchVerdict judge_in(AccessControlAdapter& adapter, const EndpointScope& scope,
                      const MatchQuestion& question) {
  Exception why{};
  const bool allowed = allowed_at_c_boundary(adapter.host(), &why, [&] {
    spi::AccessControl::Match match{.remote_writes = question.remote_writes != 0,
                                    .local = scope.request(),
                                    .remote = std::nullopt,
                                    .remote_hides = question.peer_hides_endpoints != 0};
    if (question.peer_prefix != nullptr)
      match.remote = GuidPrefix::from({question.peer_prefix, GuidPrefix::size});
    return adapter.plugin().check_remote_match({question.remote_permissions}, match);
  });
  std::free(why.message);
  if (why.code == static_cast<DDS_Security_long>(Code::out_of_memory))
    return MatchVerdict::out_of_memory;
  return allowed ? MatchVerdict::allowed : MatchVerdict::refused;
}

}  // namespace

void AccessControlAdapter::register_in_process() {
  const std::unique_lock lock(adapters().mutex);
  adapters().by_id.emplace(id_, this);
}

void AccessControlAdapter::unregister_from_process() {
  const std::unique_lock lock(adapters().mutex);
  adapters().by_id.erase(id_);
}

MatchVerdict AccessControlAdapter::judge(const MatchQuestion* question) noexcept {
  try {
    if (question == nullptr || question->scope == nullptr)
      return MatchVerdict::unknown_access_control;
    const auto scope = EndpointScope::from(*question->scope);
    if (!scope) return MatchVerdict::unknown_access_control;
    const std::shared_lock lock(adapters().mutex);
    const auto found = adapters().by_id.find(scope->access_control());
    if (found == adapters().by_id.end()) return MatchVerdict::unknown_access_control;
    return judge_in(*found->second, *scope, *question);
  } catch (...) {
    // This verdict does not allow the match, and cryptography reports it.
    return MatchVerdict::out_of_memory;
  }
}

void AccessControlAdapter::cut_off(spi::IdentityHandle local) {
  const std::shared_lock lock(adapters().mutex);
  for (const auto& [id, adapter] : adapters().by_id)
    adapter->facts_.cut_off(local, Code::identity_ended);
}

void AccessControlAdapter::return_permissions_of(spi::IdentityHandle peer) noexcept {
  try {
    const std::shared_lock lock(adapters().mutex);
    for (const auto& [id, adapter] : adapters().by_id)
      for (const auto permissions : adapter->peer_permissions_.take(peer))
        static_cast<void>(adapter->plugin().return_permissions_handle(permissions));
  } catch (...) {
    // If memory is short, the handles stay.
  }
}

std::optional<AccessControlAdapter::RenewedDocument> AccessControlAdapter::renewed_permissions(
    spi::IdentityHandle local, std::uint64_t known) noexcept {
  try {
    const std::shared_lock lock(adapters().mutex);
    for (const auto& [id, adapter] : adapters().by_id) {
      const auto permissions = adapter->facts_.permissions_of(local);
      if (!permissions) continue;
      const auto times = adapter->plugin().renewals(*permissions);
      if (times <= known) return std::nullopt;
      const auto token = adapter->plugin().permissions_credential_token(*permissions);
      if (!token) return std::nullopt;
      return RenewedDocument{times,
                             std::string(spi::property_value(token->properties, "dds.perm.cert"))};
    }
  } catch (...) {
    // If memory is short, the question comes again.
  }
  return std::nullopt;
}

std::uint64_t AccessControlAdapter::rights_changed(spi::IdentityHandle local) noexcept {
  try {
    const std::shared_lock lock(adapters().mutex);
    for (const auto& [id, adapter] : adapters().by_id)
      if (const auto permissions = adapter->facts_.permissions_of(local))
        return adapter->endpoints_.changes(*permissions);
  } catch (...) {
    // The question comes again.
  }
  return 0;
}

std::uint32_t AccessControlAdapter::governance_facts_of(spi::IdentityHandle local) noexcept {
  try {
    const std::shared_lock lock(adapters().mutex);
    for (const auto& [id, adapter] : adapters().by_id)
      if (const auto facts = adapter->facts_.of(local); facts != 0) return facts;
  } catch (...) {
    // The answer is then that no fact is known.
  }
  return 0;
}

}  // namespace ddssec::cyclonedds
