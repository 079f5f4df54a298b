#include "plugins/cyclonedds/own_endpoints.hpp"

#include <algorithm>
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

Error rights_gained_event(bool writes, const std::string& topic) {
  return Error(Code::own_rights_gained,
               {.document = fmt::format("the {} of topic {}", writes ? "writer" : "reader", topic),
                .note = "a peer on other plugins learns of the right when the former permissions "
                        "end"});
}

}  // namespace

// The request refers to the endpoint, which must not move.
struct OwnEndpoints::Request {
  explicit Request(const Endpoint& endpoint)
      : writes(endpoint.writes),
        topic(endpoint.topic),
        partitions(endpoint.partitions.begin(), endpoint.partitions.end()),
        data_tags(endpoint.data_tags) {}
  spi::EndpointRequest request() const {
    return {.topic_name = topic, .partitions = partitions, .data_tags = data_tags};
  }
  bool writes;
  const std::string& topic;
  std::vector<std::string_view> partitions;
  const spi::PropertyList& data_tags;
};

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
  changes_.erase(local);
  std::erase_if(endpoints_, [&](const auto& entry) { return entry.second.local == local; });
}

std::optional<Error> OwnEndpoints::poll(spi::PermissionsHandle local, spi::AccessControl& plugin,
                                        Duration now) {
  const auto renewals = plugin.renewals(local);
  const std::lock_guard lock(mutex_);
  if (auto lost = find_lost(local, renewals, plugin)) return lost;
  auto& last = changes_[local];
  if (last.renewals >= renewals) return std::nullopt;
  const auto* const gained = find_gained(local, plugin, now);
  if (gained == nullptr) return std::nullopt;
  last = {last.count + 1, renewals};  // also counted if there is no memory for the event
  return rights_gained_event(gained->writes, gained->topic);
}

// The caller holds the lock.
std::optional<Error> OwnEndpoints::find_lost(spi::PermissionsHandle local, std::uint64_t renewals,
                                             spi::AccessControl& plugin) {
  auto& last = changes_[local];
  std::optional<Error> first;
  std::size_t lost = 0;
  for (auto& [place, endpoint] : endpoints_) {
    if (endpoint.local != local || endpoint.judged == renewals) continue;
    const auto status =
        plugin.check_own_endpoint(local, endpoint.writes, Request(endpoint).request());
    endpoint.judged = renewals;
    endpoint.asked.reset();
    const bool was_allowed = std::exchange(endpoint.is_allowed, !is_denial(status));
    if (!was_allowed || endpoint.is_allowed) continue;
    if (++lost > 1) continue;
    last = {last.count + 1, renewals};  // also counted if there is no memory for the event
    first = status.error();
  }
  if (!first) return std::nullopt;
  return rights_lost_event(*first, lost - 1);
}

// A handshake that was under way presents the former permissions. It usually ends before the second
// question, but the host repeats its message for as long as the peer does not answer, and an
// attacker can hold back the answer. So the question comes again, after twice the time.
void OwnEndpoints::note_asked(Endpoint& endpoint, Duration now) {
  constexpr Duration kFirst = std::chrono::seconds(12), kMaxPause = std::chrono::minutes(10);
  endpoint.pause = endpoint.asked ? std::min(2 * endpoint.pause, kMaxPause) : kFirst;
  endpoint.asked = now;
}

bool OwnEndpoints::is_due(const Endpoint& endpoint, Duration now) {
  return endpoint.is_allowed && (!endpoint.asked || now - *endpoint.asked >= endpoint.pause);
}

// The caller holds the lock, and has judged the endpoints by the permissions in force.
const OwnEndpoints::Endpoint* OwnEndpoints::find_gained(spi::PermissionsHandle local,
                                                        spi::AccessControl& plugin, Duration now) {
  std::vector<Endpoint*> due;
  std::vector<Request> requests;
  for (auto& [place, endpoint] : endpoints_) {
    if (endpoint.local != local || !is_due(endpoint, now)) continue;
    due.push_back(&endpoint);
    requests.emplace_back(endpoint);
  }
  if (due.empty()) return nullptr;
  std::vector<spi::AccessControl::OwnEndpoint> asked;
  for (const auto& one : requests) asked.push_back({one.writes, one.request()});
  const auto found = plugin.find_unknown_right(local, asked);
  // Only now: a question that could not be asked for want of memory is asked again.
  for (auto* const endpoint : due) note_asked(*endpoint, now);
  return found && *found < due.size() ? due[*found] : nullptr;
}

std::uint64_t OwnEndpoints::changes(spi::PermissionsHandle local) const {
  const std::lock_guard lock(mutex_);
  const auto known = changes_.find(local);
  return known == changes_.end() ? 0 : known->second.count;
}

}  // namespace ddssec::cyclonedds
