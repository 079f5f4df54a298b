// AnyDataWriter, the part that DURABILITY TRANSIENT and PERSISTENT are about (DDS 1.4, 2.2.3.4).
#include "rtps/dcps/domain_participant.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::size_t kMostOctetsInMemory = std::size_t{256} << 20;

}  // namespace

Result<DurableStore*> DomainParticipant::store_for(DurabilityKind kind) {
  auto& events = context_.environment().events;
  if (kind == DurabilityKind::persistent && persistent_) return persistent_.get();
  if (kind == DurabilityKind::persistent)
    events.raise(Event(Error(Code::rtps_store_unusable,
                             {.document = "participant options",
                              .field = "durability_store",
                              .expected = "a path, for a writer with DURABILITY PERSISTENT",
                              .found = "none: its samples last as long as the participant"})));
  if (!transient_) transient_ = DDSSEC_TRY(DurableStore::open("", events, kMostOctetsInMemory));
  return transient_.get();
}

Status AnyDataWriter::restore(EndpointRequest& request) {
  auto& participant = publisher().participant();
  auto* store = DDSSEC_TRY(participant.store_for(qos_.durability));
  StreamKey key{.domain = static_cast<std::uint32_t>(participant.domain_id()),
                .topic = request.topic_name,
                .type = request.type_name,
                .partition = request.qos.partition};
  auto opened = DDSSEC_TRY(store->open_stream(std::move(key), request.qos.durability_service));
  store_ = store;
  stream_ = opened.id;
  const auto [now, wall] = context_.moment();
  const auto lifespan = qos_.lifespan.to_nanoseconds();
  for (auto& change : opened.history) {
    const auto age = wall.to_nanoseconds() - change.source_time.value_or(wall).to_nanoseconds();
    if (!qos_.lifespan.is_infinite() && age >= lifespan) continue;
    instances_->enter(change.key_hash.value_or(KeyHash{}), [&] {
      const auto& serialized_key = topic_.type().serialized_key;
      return serialized_key ? serialized_key(change) : Bytes{};
    });
    request.history.push_back(std::move(change));
    if (!qos_.lifespan.is_infinite())
      expiring_.push_back({now + lifespan - age,
                           SequenceNumber{static_cast<std::int64_t>(request.history.size())}});
  }
  return {};
}

Status AnyDataWriter::wait_for_store(std::unique_lock<std::mutex>& lock) {
  DDSSEC_TRY(store_->status());
  if (!store_->is_behind()) return {};
  lock.unlock();
  auto room = store_->wait_for_room(qos_.reliability.max_blocking_time.to_nanoseconds());
  lock.lock();
  return room;
}

}  // namespace ddssec::rtps
