#include "rtps/qos/qos.hpp"

#include <fmt/format.h>

namespace ddssec::rtps {
namespace {

Status inconsistent(std::string field, std::string expected, std::string found) {
  return fail(Code::rtps_qos_inconsistent, {.document = "QoS",
                                            .field = std::move(field),
                                            .expected = std::move(expected),
                                            .found = std::move(found)});
}

bool exceeds(std::int32_t value, std::int32_t limit) {
  return limit != kLengthUnlimited && value > limit;
}

Status check_limit(std::string_view name, std::int32_t value) {
  if (value == kLengthUnlimited || value > 0) return {};
  return inconsistent(std::string(name), "unlimited (-1) or at least 1", std::to_string(value));
}

Status check_limits(const std::string& policy, const ResourceLimits& limits) {
  DDSSEC_RETURN_IF_ERROR(check_limit(policy + ".max_samples", limits.max_samples));
  DDSSEC_RETURN_IF_ERROR(check_limit(policy + ".max_instances", limits.max_instances));
  return check_limit(policy + ".max_samples_per_instance", limits.max_samples_per_instance);
}

Status check_depth(const std::string& field, const History& history) {
  if (history.kind != HistoryKind::keep_last || history.depth >= 1) return {};
  return inconsistent(field, "at least 1", std::to_string(history.depth));
}

Status immutable(std::string_view policy) {
  return fail(Code::rtps_immutable_policy, {.document = "QoS", .field = std::string(policy)});
}

}  // namespace

Status check_mutable(const Qos& from, const Qos& to) {
  if (from.reliability != to.reliability) return immutable("RELIABILITY");
  if (from.durability != to.durability) return immutable("DURABILITY");
  if (from.durability_service != to.durability_service) return immutable("DURABILITY_SERVICE");
  if (from.history != to.history) return immutable("HISTORY");
  if (from.resource_limits != to.resource_limits) return immutable("RESOURCE_LIMITS");
  if (from.liveliness != to.liveliness) return immutable("LIVELINESS");
  if (from.ownership != to.ownership) return immutable("OWNERSHIP");
  if (from.destination_order != to.destination_order) return immutable("DESTINATION_ORDER");
  if (from.presentation != to.presentation) return immutable("PRESENTATION");
  if (from.properties != to.properties) return immutable("PROPERTY");
  if (from.data_tags != to.data_tags) return immutable("DATA_TAGS");
  if (from.data_representation != to.data_representation) return immutable("DATA_REPRESENTATION");
  if (from.type_consistency != to.type_consistency)
    return immutable("TYPE_CONSISTENCY_ENFORCEMENT");
  return {};
}

Status check_consistency(const DurabilityService& service) {
  DDSSEC_RETURN_IF_ERROR(check_limits("DURABILITY_SERVICE", service.limits));
  return check_depth("DURABILITY_SERVICE.history_depth", service.history);
}

Status check_consistency(const Qos& qos) {
  const auto& limits = qos.resource_limits;
  DDSSEC_RETURN_IF_ERROR(check_limits("RESOURCE_LIMITS", limits));
  DDSSEC_RETURN_IF_ERROR(check_depth("HISTORY.depth", qos.history));
  DDSSEC_RETURN_IF_ERROR(check_consistency(qos.durability_service));
  const bool keep_last = qos.history.kind == HistoryKind::keep_last;
  if (keep_last && exceeds(qos.history.depth, limits.max_samples_per_instance))
    return inconsistent("HISTORY.depth",
                        fmt::format("at most RESOURCE_LIMITS.max_samples_per_instance, {}",
                                    limits.max_samples_per_instance),
                        std::to_string(qos.history.depth));
  if (exceeds(limits.max_samples_per_instance, limits.max_samples))
    return inconsistent("RESOURCE_LIMITS.max_samples_per_instance",
                        fmt::format("at most max_samples, {}", limits.max_samples),
                        std::to_string(limits.max_samples_per_instance));
  if (qos.deadline < qos.time_based_filter)
    return inconsistent("DEADLINE.period",
                        "at least TIME_BASED_FILTER, " + to_string(qos.time_based_filter),
                        to_string(qos.deadline));
  if (qos.partition.size() > kMaxPartitions)
    return inconsistent("PARTITION", fmt::format("at most {} names", kMaxPartitions),
                        std::to_string(qos.partition.size()));
  if (qos.data_tags.size() > kMaxDataTags)
    return inconsistent("DATA_TAGS", fmt::format("at most {} tags", kMaxDataTags),
                        std::to_string(qos.data_tags.size()));
  if (qos.data_representation.empty())
    return inconsistent("DATA_REPRESENTATION", "at least one", "none");
  return {};
}

}  // namespace ddssec::rtps
