#include "plugins/access_control/allowed_endpoints.hpp"

#include <algorithm>
#include <iterator>

#include "governance/pattern.hpp"

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

Status at_most(std::size_t limit, std::size_t found, std::string_view what, std::string_view unit) {
  if (found <= limit) return {};
  return fail(Code::length_out_of_range,
              {.field = std::string(what),
               .expected = "at most " + std::to_string(limit) + ' ' + std::string(unit),
               .found = std::to_string(found),
               .hint = "give the peer's endpoint shorter names and fewer partitions"});
}

}  // namespace

Status check_topic_length(std::string_view topic) {
  return at_most(kMaxNameOctets, topic.size(), "topic name", "octets");
}

Status check_lengths(const spi::EndpointRequest& request) {
  DDSSEC_RETURN_IF_ERROR(check_topic_length(request.topic_name));
  DDSSEC_RETURN_IF_ERROR(
      at_most(kMaxPartitions, request.partitions.size(), "PARTITION", "partitions"));
  for (const auto partition : request.partitions)
    DDSSEC_RETURN_IF_ERROR(at_most(kMaxNameOctets, partition.size(), "partition", "octets"));
  return at_most(kMaxRequestOctets, octets_of(request), "topic name, partitions and data tags",
                 "octets");
}

PartitionNames::PartitionNames(std::span<const std::string_view> names) {
  for (const auto name : names) {
    auto& added = names_.emplace_back(Name{std::string(name), {}});
    if (is_wildcard(name)) added.expression.emplace(name);
  }
  if (names_.empty()) names_.emplace_back();
}

bool PartitionNames::Name::overlaps(const Name& other) const {
  if (text == other.text) return true;
  if (expression.has_value() == other.expression.has_value()) return false;
  return expression ? expression->matches(other.text) : other.expression->matches(text);
}

bool PartitionNames::overlap(const PartitionNames& others) const {
  return std::ranges::any_of(names_, [&](const Name& name) {
    return std::ranges::any_of(others.names_,
                               [&](const Name& other) { return name.overlaps(other); });
  });
}

std::vector<std::string_view> PartitionNames::views() const {
  std::vector<std::string_view> out;
  for (const auto& name : names_) out.push_back(name.text);
  return out;
}

bool PartitionNames::operator==(const PartitionNames& others) const {
  return std::ranges::equal(names_, others.names_, {}, &Name::text, &Name::text);
}

std::size_t PartitionNames::octets() const {
  std::size_t octets = 0;
  for (const auto& name : names_) {
    octets += sizeof name + name.text.size();
    if (!name.expression) continue;
    octets += name.expression->text().size();
    for (const auto& step : name.expression->steps()) {
      octets += sizeof step;
      if (step.kind == governance::Pattern::Kind::set) octets += sizeof(std::bitset<256>);
    }
  }
  return octets;
}

AllowedEndpoints::Announcement::Announcement(Action of, const spi::EndpointRequest& request)
    : action(of),
      topic(request.topic_name),
      partitions(request.partitions),
      data_tags(request.data_tags.begin(), request.data_tags.end()) {}

std::size_t AllowedEndpoints::Announcement::octets() const {
  auto octets = sizeof *this + topic.size() + partitions.octets();
  for (const auto& tag : data_tags) octets += sizeof tag + tag.name.size() + tag.value.size();
  return octets;
}

void AllowedEndpoints::note(Action action, const spi::EndpointRequest& request) {
  if (octets_of(request) > kMaxOctets) return;
  std::list<One> fresh;
  fresh.push_back(std::make_shared<const Announcement>(action, request));
  const std::lock_guard lock(mutex_);
  const auto known =
      std::ranges::find_if(newest_first_, [&](const One& one) { return *one == *fresh.front(); });
  if (known != newest_first_.end()) {
    newest_first_.splice(newest_first_.begin(), newest_first_, known);
    return;
  }
  newest_first_.splice(newest_first_.begin(), fresh);
  octets_ += newest_first_.front()->octets();
  while (newest_first_.size() > kMax || (newest_first_.size() > 1 && octets_ > kMaxMemory)) {
    octets_ -= newest_first_.back()->octets();
    newest_first_.pop_back();
  }
}

std::vector<AllowedEndpoints::One> AllowedEndpoints::all() const {
  const std::lock_guard lock(mutex_);
  return {newest_first_.begin(), newest_first_.end()};
}

std::vector<AllowedEndpoints::One> AllowedEndpoints::of_topic(Action action,
                                                              std::string_view topic) const {
  const std::lock_guard lock(mutex_);
  std::vector<One> out;
  std::ranges::copy_if(newest_first_, std::back_inserter(out), [&](const One& one) {
    return one->action == action && one->topic == topic;
  });
  return out;
}

}  // namespace ddssec::access_control
