#include "plugins/access_control/announced.hpp"

#include <algorithm>
#include <iterator>

#include "governance/matcher.hpp"

namespace ddssec::access_control {
namespace {

std::size_t octets_of(const spi::EndpointRequest& request) {
  auto octets = request.topic_name.size();
  for (const auto partition : request.partitions) octets += partition.size() + 1;
  for (const auto& tag : request.data_tags) octets += tag.name.size() + tag.value.size() + 2;
  return octets;
}

bool is_wildcard(std::string_view partition) {
  return partition.find_first_of("*?[") != partition.npos;
}

/// DDS 2.2.3.13: equal, or one is an expression that the other, a name, fits.
bool meet(std::string_view a, std::string_view b) {
  if (a == b) return true;
  if (is_wildcard(a) == is_wildcard(b)) return false;
  return is_wildcard(a) ? governance::Pattern(a).matches(b) : governance::Pattern(b).matches(a);
}

/// No partition is the partition "".
bool meet(std::span<const std::string_view> a, std::span<const std::string_view> b) {
  static constexpr std::string_view kDefault[] = {""};
  const auto names = a.empty() ? std::span<const std::string_view>(kDefault) : a;
  const auto others = b.empty() ? std::span<const std::string_view>(kDefault) : b;
  return std::ranges::any_of(names, [&](std::string_view name) {
    return std::ranges::any_of(others, [&](std::string_view other) { return meet(name, other); });
  });
}

}  // namespace

AnnouncedEndpoints::Announced::Announced(Action of, const spi::EndpointRequest& request)
    : action(of),
      topic(request.topic_name),
      partitions(request.partitions.begin(), request.partitions.end()),
      data_tags(request.data_tags.begin(), request.data_tags.end()) {}

std::vector<std::string_view> AnnouncedEndpoints::Announced::partition_views() const {
  return {partitions.begin(), partitions.end()};
}

void AnnouncedEndpoints::note(Action action, const spi::EndpointRequest& request) {
  if (octets_of(request) > kMostOctets) return;
  std::list<Announced> fresh;
  fresh.emplace_back(action, request);
  const std::lock_guard lock(mutex_);
  std::erase(newest_first_, fresh.front());
  newest_first_.splice(newest_first_.begin(), fresh);
  if (newest_first_.size() > kMost) newest_first_.pop_back();
}

std::vector<AnnouncedEndpoints::Announced> AnnouncedEndpoints::meeting(
    Action action, const spi::EndpointRequest& ours) const {
  const std::lock_guard lock(mutex_);
  std::vector<Announced> out;
  std::ranges::copy_if(newest_first_, std::back_inserter(out), [&](const Announced& one) {
    return one.action == action && one.topic == ours.topic_name &&
           meet(one.partition_views(), ours.partitions);
  });
  return out;
}

}  // namespace ddssec::access_control
