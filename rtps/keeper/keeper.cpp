#include "rtps/keeper/keeper.hpp"

#include <algorithm>
#include <functional>

#include "base/hash.hpp"
#include "rtps/keeper/kept_topic.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::size_t kMostAnnouncement = 64 << 10;

/// Topic, type and partitions; a name never holds a NUL.
KeyHash key_of(const EndpointData& writer) {
  auto text = writer.topic_name + '\0' + writer.type_name;
  for (const auto& name : writer.qos.partition) text += '\0' + name;
  return md5(as_bytes(text));
}

/// A stream that no writer can have: topics have names.
StreamKey stream_of_announcements(DomainId domain) {
  return {.domain = static_cast<std::uint32_t>(domain), .topic = "", .type = "kept"};
}

Change announcement(const EndpointData& writer, const KeyHash& key) {
  Bytes octets(kMostAnnouncement);
  SpanWriter out(octets);
  write_payload(out, writer);
  Change change;
  change.key_hash = key;
  change.payload = Payload::copy_of(out.view());
  return change;
}

}  // namespace

Result<std::unique_ptr<Keeper>> Keeper::create(DomainParticipantOptions options,
                                               KeeperOptions keeps,
                                               const Environment& environment) {
  auto store = DDSSEC_TRY(DurableStore::open(keeps.store, environment.events, keeps.store_octets));
  auto participant = DDSSEC_TRY(DomainParticipant::create(std::move(options), environment));
  std::unique_ptr<Keeper> out(
      new Keeper(std::move(participant), std::move(store), std::move(keeps.topics)));
  DDSSEC_TRY(out->start());
  return out;
}

Keeper::Keeper(std::unique_ptr<DomainParticipant> participant, std::unique_ptr<DurableStore> store,
               std::vector<std::string> topics)
    : participant_(std::move(participant)),
      store_(std::move(store)),
      patterns_(std::move(topics)) {}

Keeper::~Keeper() {
  if (auto* reader = participant_->builtin_datareader<PublicationBuiltinTopicData>())
    reader->set_listener(nullptr);
}

Status Keeper::start() {
  DDSSEC_TRY(participant_->ignore_participant(participant_->guid()));
  auto known = DDSSEC_TRY(
      store_->open_stream(stream_of_announcements(participant_->domain_id()), DurabilityService{}));
  known_ = known.id;
  for (const auto& change : known.history)
    if (const auto writer = read_publication_data(change.payload.view()))
      DDSSEC_TRY(keep(*writer, true));
  auto* reader = participant_->builtin_datareader<PublicationBuiltinTopicData>();
  reader->set_listener(this, StatusKind::data_available);
  on_data_available(*reader);
  return {};
}

void Keeper::on_data_available(AnyDataReader& any) {
  auto& reader = static_cast<BuiltinDataReader<PublicationBuiltinTopicData>&>(any);
  std::vector<BuiltinSample<PublicationBuiltinTopicData>> found;
  if (!reader.take(found)) return;
  for (const auto& [writer, info] : found) {
    if (!info.valid_data || !wants(writer)) continue;
    if (const auto kept = keep(writer, false); !kept)
      participant_->context_.environment().events.raise(Event(kept.error()));
  }
}

bool Keeper::wants(const EndpointData& writer) const {
  return writer.qos.durability >= DurabilityKind::transient &&
         std::ranges::any_of(patterns_, [&](const auto& pattern) {
           return glob_match(pattern, writer.topic_name);
         });
}

Status Keeper::keep(const EndpointData& writer, bool is_known) {
  const auto key = key_of(writer);
  const std::lock_guard held(mutex_);
  if (topics_.contains(key)) return {};
  if (topics_.size() >= kMostTopics)
    return fail(Code::rtps_store_failed, {.document = "keeper",
                                          .field = "topics",
                                          .expected = "at most " + std::to_string(kMostTopics),
                                          .found = writer.topic_name});
  auto topic = std::make_unique<KeptTopic>(participant_->context_, *store_, writer);
  DDSSEC_TRY(topic->open(participant_->domain_id()));
  if (!is_known) store_->append(known_, announcement(writer, key), participant_->current_time());
  topics_.emplace(key, std::move(topic));
  return {};
}

std::size_t Keeper::topics() const {
  const std::lock_guard held(mutex_);
  return topics_.size();
}

template <class Count>
std::uint64_t Keeper::sum(Count count) const {
  const std::lock_guard held(mutex_);
  const std::lock_guard lock(participant_->context_.mutex());
  std::uint64_t out = 0;
  for (const auto& [key, topic] : topics_) out += std::invoke(count, *topic);
  return out;
}

std::uint64_t Keeper::without_key() const { return sum(&KeptTopic::without_key); }
std::uint64_t Keeper::dropped() const { return sum(&KeptTopic::dropped); }

}  // namespace ddssec::rtps
