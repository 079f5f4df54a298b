#include "plugins/cyclonedds/access_control_gate.hpp"

#include <dlfcn.h>

#include "plugins/cyclonedds/endpoint_scope.hpp"
#include "plugins/cyclonedds/token_translation.hpp"

namespace ddssec::cyclonedds {

Result<std::shared_ptr<const AccessControlGate>> AccessControlGate::of(
    const DDS_Security_PropertySeq& properties) {
  if (!is_scope(properties)) return nullptr;
  DDSSEC_ASSIGN_OR_RETURN(auto property_list, properties_from(properties));
  return std::make_shared<const AccessControlGate>(std::move(property_list));
}

AccessControlGate::AccessControlGate(spi::PropertyList scope, JudgeMatch* judge)
    : scope_(std::move(scope)), judge_(judge) {
  // The C type has no const; nothing writes to the text.
  for (auto& one : scope_) as_c_.push_back({one.name.data(), one.value.data(), one.propagate});
}

Status AccessControlGate::check(const Peer& peer) const {
  auto* const judge = judge_ != nullptr
                          ? judge_
                          : reinterpret_cast<JudgeMatch*>(dlsym(RTLD_DEFAULT, kJudgeMatchSymbol));
  if (judge == nullptr) return fail(Code::access_control_missing);
  const auto count = static_cast<DDS_Security_unsigned_long>(as_c_.size());
  const DDS_Security_PropertySeq scope{count, count,
                                       const_cast<DDS_Security_Property_t*>(as_c_.data())};
  const MatchQuestion question{.scope = &scope,
                               .remote_permissions = peer.permissions.value,
                               .remote_writes = peer.writes,
                               .peer_prefix = peer.prefix ? peer.prefix->octets.data() : nullptr,
                               .peer_hides_endpoints = peer.hides_endpoints};
  switch (judge(&question)) {
    case MatchVerdict::allowed:
      return {};
    case MatchVerdict::refused:
      return fail(Code::keys_not_permitted);
    case MatchVerdict::out_of_memory:
      return fail(Code::out_of_memory);
    case MatchVerdict::unknown_access_control:
      break;
  }
  return fail(Code::access_control_missing);
}

}  // namespace ddssec::cyclonedds
