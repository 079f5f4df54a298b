#include "plugins/cyclonedds/own_endpoints.hpp"

#include <utility>

#include <fmt/format.h>

namespace ddssec::cyclonedds {
namespace {

// True for a refusal of the endpoint itself. Other refusals are not about the endpoint: permissions
// that have ended cut the participant off.
bool is_denial(const Status& status) {
  return !status && (status.error().code() == Code::publish_not_allowed ||
                     status.error().code() == Code::subscribe_not_allowed);
}

Error rights_lost_event(const Error& first, std::size_t more) {
  auto details = first.details();
  if (!details.note.empty()) details.note += "; ";
  if (more > 0) details.note += fmt::format("{} more endpoints lost their rights; ", more);
  details.note += "a peer on other plugins keeps the session until the former permissions end";
  details.hint.clear();
  return Error(Code::own_rights_lost, std::move(details));
}

}  // namespace

void OwnEndpoints::add(Place place, spi::PermissionsHandle local, bool writes,
                       const spi::EndpointRequest& request) {
  Endpoint endpoint{.local = local,
                    .writes = writes,
                    .topic = std::string(request.topic_name),
                    .partitions = {request.partitions.begin(), request.partitions.end()},
                    .data_tags = {request.data_tags.begin(), request.data_tags.end()}};
  const std::lock_guard lock(mutex_);
  endpoints_.insert_or_assign(place, std::move(endpoint));
}

void OwnEndpoints::remove(Place place) {
  const std::lock_guard lock(mutex_);
  endpoints_.erase(place);
}

void OwnEndpoints::forget(spi::PermissionsHandle local) {
  const std::lock_guard lock(mutex_);
  losses_.erase(local);
  std::erase_if(endpoints_, [&](const auto& entry) { return entry.second.local == local; });
}

Status OwnEndpoints::ask(const Endpoint& endpoint, spi::AccessControl& plugin) {
  const std::vector<std::string_view> partitions(endpoint.partitions.begin(),
                                                 endpoint.partitions.end());
  return plugin.check_own_endpoint(
      endpoint.local, endpoint.writes,
      {.topic_name = endpoint.topic, .partitions = partitions, .data_tags = endpoint.data_tags});
}

std::optional<Error> OwnEndpoints::poll(spi::PermissionsHandle local, spi::AccessControl& plugin) {
  const auto renewals = plugin.renewals(local);
  const std::lock_guard lock(mutex_);
  auto& losses = losses_[local];
  std::optional<Error> first;
  std::size_t lost = 0;
  for (auto& [place, endpoint] : endpoints_) {
    if (endpoint.local != local || endpoint.judged == renewals) continue;
    const auto status = ask(endpoint, plugin);
    endpoint.judged = renewals;
    const bool was_allowed = std::exchange(endpoint.is_allowed, !is_denial(status));
    if (!was_allowed || endpoint.is_allowed) continue;
    if (++lost > 1) continue;
    ++losses;  // also counted if there is no memory for the event
    first = status.error();
  }
  if (!first) return std::nullopt;
  return rights_lost_event(*first, lost - 1);
}

std::uint64_t OwnEndpoints::losses(spi::PermissionsHandle local) const {
  const std::lock_guard lock(mutex_);
  const auto known = losses_.find(local);
  return known == losses_.end() ? 0 : known->second;
}

}  // namespace ddssec::cyclonedds
