#include "rtps/dcps/endpoint.hpp"

#include <algorithm>

#include "rtps/dcps/count_status.hpp"
#include "rtps/dcps/group.hpp"
#include "rtps/participant/partition_change.hpp"
#include "rtps/participant/rtps_participant.hpp"

namespace ddssec::rtps {

Endpoint::Endpoint(Group& group, ParticipantContext& context, Topic& topic, Qos qos,
                   const Side& side)
    : Entity(context), group_(group), topic_(topic), side_(side), qos_(std::move(qos)) {
  const auto held = lock();
  ++topic_.users_;
}

void Endpoint::retire() {
  const auto held = lock();
  if (std::exchange(is_retired_, true)) return;
  --topic_.users_;
  if (enabled() && !is_builtin(guid_.entity)) {
    context_.protocol().remove(guid_, context_.now());
    context_.reschedule();
  }
  on_retired();
}

Guid Endpoint::guid() const {
  const auto held = lock();
  return guid_;
}

Qos Endpoint::qos() const {
  const auto held = lock();
  return qos_;
}

Status Endpoint::enable() {
  if (!group_.is_enabled())
    return precondition_not_met_error(std::string(side_.name),
                                      "an enabled " + std::string(side_.group), "a disabled one");
  DDSSEC_ASSIGN_OR_RETURN(auto announced, announced_qos(qos(), group_.qos(), topic_));
  const auto held = lock();
  if (enabled()) return {};
  DDSSEC_ASSIGN_OR_RETURN(guid_, create({topic_.name(), topic_.type_name(), std::move(announced),
                                         topic_.type().with_key, topic_.type().description}));
  mark_enabled();
  context_.reschedule();
  return {};
}

Status Endpoint::set_qos(const Qos& qos) {
  DDSSEC_ASSIGN_OR_RETURN(auto announced, announced_qos(qos, group_.qos(), topic_));
  const auto held = lock();
  if (enabled()) {
    DDSSEC_RETURN_IF_ERROR(check_mutable(qos_, qos));
    DDSSEC_RETURN_IF_ERROR(
        context_.protocol().change_qos(guid_, std::move(announced), context_.now()));
  }
  const auto before = std::exchange(qos_, qos);
  on_own_qos(before);
  if (enabled()) context_.reschedule();
  return {};
}

Status Endpoint::check_regroup(const GroupQos& group) {
  DDSSEC_ASSIGN_OR_RETURN(const auto announced, announced_qos(qos(), group, topic_));
  const auto held = lock();
  if (!enabled()) return {};
  auto& protocol = context_.protocol();
  return check_partition_change(protocol.remote_participants().core(), protocol.local_endpoints(),
                                guid_.entity, announced);
}

Status Endpoint::regroup(const GroupQos& group) {
  DDSSEC_ASSIGN_OR_RETURN(auto announced, announced_qos(qos(), group, topic_));
  const auto held = lock();
  if (!enabled()) return {};
  DDSSEC_RETURN_IF_ERROR(
      context_.protocol().change_qos(guid_, std::move(announced), context_.now()));
  context_.reschedule();
  return {};
}

void Endpoint::on_matched(const EndpointData& remote) {
  if (!remotes_.insert(remote.guid).second) return;
  add_to(matched_);
  ++matched_.current_count;
  ++matched_.current_count_change;
  matched_.last_remote = remote.guid;
  changes_.note(side_.matched);
}

void Endpoint::on_unmatched(const Guid& remote) {
  if (remotes_.erase(remote) == 0) return;
  --matched_.current_count;
  --matched_.current_count_change;
  matched_.last_remote = remote;
  changes_.note(side_.matched);
}

void Endpoint::on_incompatible_qos(const Guid& remote, const QosMismatch& mismatch) {
  add_to(incompatible_);
  incompatible_.last_policy_id = mismatch.id;
  ++incompatible_.policies[mismatch.id];
  incompatible_.last = mismatch;
  incompatible_.last_remote = remote;
  changes_.note(side_.incompatible_qos);
}

void Endpoint::on_inconsistent_topic(const EndpointData&) { topic_.on_inconsistent(); }

void Endpoint::miss_deadline(InstanceHandle instance) {
  add_to(deadline_missed_);
  deadline_missed_.last_instance_handle = instance;
  changes_.note(side_.deadline_missed);
}

MatchedStatus Endpoint::read_matched_status() {
  const auto held = lock();
  changes_.clear(side_.matched);
  const auto out = matched_;
  matched_.total_count_change = matched_.current_count_change = 0;
  return out;
}

std::vector<Guid> Endpoint::matched_remotes() const {
  const auto held = lock();
  return {remotes_.begin(), remotes_.end()};
}

Result<EndpointData> Endpoint::matched_data(const Guid& remote) const {
  const auto held = lock();
  const auto* data = remotes_.contains(remote)
                         ? context_.protocol().remote_participants().endpoint(remote)
                         : nullptr;
  if (data != nullptr) return *data;
  return fail(Code::rtps_bad_parameter,
              {.expected = "a matched endpoint", .found = remote.to_string()});
}

}  // namespace ddssec::rtps
