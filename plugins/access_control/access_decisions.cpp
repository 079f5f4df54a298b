#include "plugins/access_control/access_decisions.hpp"

#include <algorithm>

#include "plugins/access_control/refusals.hpp"

namespace ddssec::access_control {
namespace {

using governance::Action;
using spi::EndpointRequest;

bool is_access_controlled(const governance::TopicRule& rule, Action action) {
  return action == Action::publish ? rule.enable_write_access_control
                                   : rule.enable_read_access_control;
}

std::vector<governance::DataTag> data_tags_of(const EndpointRequest& request) {
  std::vector<governance::DataTag> tags;
  for (const auto& tag : request.data_tags) tags.push_back({tag.name, tag.value});
  return tags;
}

}  // namespace

Status AccessDecisions::check_participant(PermissionsHolder& holder) const {
  const auto documents = holder.participant()->judging_documents();
  if (!documents->governance->domain_rule().enable_join_access_control) return {};
  DDSSEC_ASSIGN_OR_RETURN(const SharedGrant grant, grant_now(holder));
  const auto decision = grant->judge_participant();
  if (!decision.allowed) return std::unexpected(participant_denied_error(holder, *grant, decision));
  return {};
}

Status AccessDecisions::check_topic(PermissionsHolder& holder, std::string_view name) const {
  if (holder.remote()) DDSSEC_RETURN_IF_ERROR(check_topic_length(name));
  const auto& participant = *holder.participant();
  const auto documents = participant.judging_documents();
  const auto* rule = documents->governance->topic_rule(name);
  if (!rule) return std::unexpected(topic_not_covered_error(participant, name));
  if (!rule->enable_read_access_control || !rule->enable_write_access_control) return {};
  DDSSEC_ASSIGN_OR_RETURN(const SharedGrant grant, grant_now(holder));
  const auto publish = grant->judge_topic(Action::publish, name);
  if (publish.allowed || grant->judge_topic(Action::subscribe, name).allowed) return {};
  return std::unexpected(topic_denied_error(holder, *grant, publish, name));
}

Status AccessDecisions::check_endpoint(PermissionsHolder& holder, Action action,
                                       const EndpointRequest& request) const {
  const auto documents = holder.participant()->judging_documents();
  return check_by(*documents->governance, holder, action, request);
}

Status AccessDecisions::check_by(const governance::CompiledGovernance& rules,
                                 PermissionsHolder& holder, Action action,
                                 const EndpointRequest& request) const {
  const auto& participant = *holder.participant();
  const auto* rule = rules.topic_rule(request.topic_name);
  if (!rule) return std::unexpected(topic_not_covered_error(participant, request.topic_name));
  if (!is_access_controlled(*rule, action)) return {};
  DDSSEC_ASSIGN_OR_RETURN(const SharedGrant grant, grant_now(holder));
  const auto tags = data_tags_of(request);
  const auto decision = grant->judge(action, {request.topic_name, request.partitions, tags});
  if (!decision.allowed)
    return std::unexpected(endpoint_denied_error(holder, *grant, decision, action, request));
  return {};
}

Status AccessDecisions::check_announced(PermissionsHolder& holder, Action action,
                                        const EndpointRequest& request) const {
  if (holder.remote()) DDSSEC_RETURN_IF_ERROR(check_lengths(request));
  const auto status = check_endpoint(holder, action, request);
  if (!holder.remote()) return status;
  if (status)
    holder.announced().note(action, request);
  else
    holder.note_denied(action, request);
  return status;
}

bool AccessDecisions::is_denied_by_any(const std::vector<SharedGrant>& grants,
                                       const PermissionsHolder& holder, Action action,
                                       const EndpointRequest& request) const {
  if (grants.empty()) return false;
  const auto documents = holder.participant()->judging_documents();
  const auto* rule = documents->governance->topic_rule(request.topic_name);
  if (!rule || !is_access_controlled(*rule, action)) return false;
  const auto tags = data_tags_of(request);
  return std::ranges::any_of(grants, [&](const SharedGrant& grant) {
    return !grant->judge(action, {request.topic_name, request.partitions, tags}).allowed;
  });
}

// The announcement is judged again, because a grant may have ended.
bool AccessDecisions::may_as_announced(PermissionsHolder& holder, Action action,
                                       const EndpointRequest& local) const {
  const auto announced = holder.announced().of_topic(action, local.topic_name);
  if (announced.empty()) return false;
  const PartitionNames ours(local.partitions);
  return std::ranges::any_of(announced, [&](const AllowedEndpoints::One& one) {
    if (!one->partitions.overlap(ours)) return false;
    const auto partitions = one->partitions.views();
    return check_endpoint(holder, action, {one->topic, partitions, one->data_tags}).has_value();
  });
}

// True only if a <relay> element allows the endpoint, because a grant's default is not meant for
// relays.
bool AccessDecisions::may_relay(PermissionsHolder& holder, const EndpointRequest& request) const {
  const auto grant = grant_now(holder);
  if (!grant) return false;
  const auto tags = data_tags_of(request);
  const auto decision =
      (*grant)->judge(Action::relay, {request.topic_name, request.partitions, tags});
  return decision.allowed && decision.criteria;
}

Result<spi::AccessControl::RemoteDatareader> AccessDecisions::check_announced_reader(
    PermissionsHolder& holder, const EndpointRequest& request) const {
  const auto status = check_announced(holder, Action::subscribe, request);
  if (status) return spi::AccessControl::RemoteDatareader{};
  if (status.error().code() == Code::announced_reader_not_allowed && accepts_relays_ &&
      may_relay(holder, request))
    return spi::AccessControl::RemoteDatareader{.is_relay_only = true};
  return std::unexpected(status.error());
}

std::optional<spi::AccessControl::RemoteDatareader> AccessDecisions::judge_pending(
    PermissionsHolder& holder, Action action, const EndpointRequest& request) const {
  const auto document = holder.participant()->pending();
  if (!document) return std::nullopt;
  if (check_by(*document->governance, holder, action, request))
    return spi::AccessControl::RemoteDatareader{};
  if (action != Action::subscribe || !accepts_relays_ || !may_relay(holder, request))
    return std::nullopt;
  return spi::AccessControl::RemoteDatareader{.is_relay_only = true};
}

}  // namespace ddssec::access_control
