#include "rtps/participant/builtin_endpoints.hpp"

#include <algorithm>

namespace ddssec::rtps {
namespace {

// Builtin writers keep the last announcement of each instance (RTPS 8.5.4).
Qos builtin_qos() {
  auto qos = default_writer_qos();
  qos.durability = DurabilityKind::transient_local;
  return qos;
}

}  // namespace

BuiltinEndpoints::BuiltinEndpoints(const GuidPrefix& prefix, MessageSender& sender,
                                   TimerQueue& timers, Deliver deliver)
    : prefix_(prefix), sender_(sender), timers_(timers), deliver_(std::move(deliver)) {
  for (const auto& info : kBuiltinTopics)
    if (!info.is_secure) add(info);
}

void BuiltinEndpoints::add_secure_endpoints() {
  for (const auto& info : kBuiltinTopics)
    if (info.is_secure) add(info);
}

void BuiltinEndpoints::add(const BuiltinTopicInfo& info) {
  const auto topic = info.topic;
  endpoints_[index(topic)] = {
      std::make_unique<StatefulWriter>(Guid{prefix_, info.writer}, builtin_qos(), sender_,
                                       &timers_),
      std::make_unique<StatefulReader>(
          Guid{prefix_, info.reader}, true, sender_,
          [this, topic](Change& change) { return deliver_(topic, change); }, &timers_)};
  endpoints_[index(topic)].reader->limit(kBuiltinLimits);
  readers_[index(topic)] = endpoints_[index(topic)].reader.get();
}

StatefulWriter* BuiltinEndpoints::find_writer(const EntityId& id) {
  const auto at = std::ranges::find(kBuiltinTopics, id, &BuiltinTopicInfo::writer);
  return at == kBuiltinTopics.end() ? nullptr : endpoints_[index(at->topic)].writer.get();
}

StatefulReader* BuiltinEndpoints::find_reader(const EntityId& id) {
  const auto at = std::ranges::find(kBuiltinTopics, id, &BuiltinTopicInfo::reader);
  return at == kBuiltinTopics.end() ? nullptr : endpoints_[index(at->topic)].reader.get();
}

std::span<StatefulReader* const> BuiltinEndpoints::readers_of(const EntityId& writer) const {
  const auto at = std::ranges::find(kBuiltinTopics, writer, &BuiltinTopicInfo::writer);
  if (at == kBuiltinTopics.end() || readers_[index(at->topic)] == nullptr) return {};
  return {&readers_[index(at->topic)], 1};
}

}  // namespace ddssec::rtps
