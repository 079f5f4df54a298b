#include "rtps/keeper/keeper.hpp"

#include <algorithm>
#include <functional>

#include <fmt/format.h>

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

// Who announces a topic first may be anybody. Until a writer that may write to it matched, another
// identity that announces it says how it is kept.
bool Keeper::is_settled(const KeyHash& key, const EndpointData& writer,
                        const GuidPrefix& identity) const {
  const auto known = topics_.find(key);
  if (known == topics_.end()) return false;
  const auto& [topic, first] = known->second;
  const std::lock_guard lock(participant_->context_.mutex());
  return topic->is_in_use() || first == identity ||
         topic->like().qos.durability_service == writer.qos.durability_service;
}

Status Keeper::keep(const EndpointData& writer, bool is_known) {
  const auto key = key_of(writer);
  const std::lock_guard held(mutex_);
  auto& context = participant_->context_;
  const auto identity = [&] {
    const std::lock_guard lock(context.mutex());
    return context.protocol().remote_participants().identity_of(writer.guid.prefix);
  }();
  if (is_settled(key, writer, identity)) return {};
  topics_.erase(key);
  if (!make_room(identity))
    return fail(Code::rtps_store_failed,
                {.document = "keeper",
                 .field = "topics",
                 .expected = fmt::format("at most {}, and of one identity as many as are free",
                                         kMostTopics),
                 .found = writer.topic_name});
  const auto remember = [this, writer, key, is_known] {
    if (!is_known)
      store_->append(known_, announcement(writer, key), participant_->context_.moment().wall);
  };
  auto topic = std::make_unique<KeptTopic>(context, *store_, writer, remember);
  DDSSEC_TRY(topic->open(participant_->domain_id()));
  topics_[key] = {std::move(topic), identity};
  return {};
}

bool Keeper::make_room(const GuidPrefix& identity) {
  std::map<GuidPrefix, std::size_t> counts;
  std::map<GuidPrefix, KeyHash> empty;  // one topic of each that has no samples
  for (const auto& [key, entry] : topics_) {
    ++counts[entry.identity];
    const std::lock_guard lock(participant_->context_.mutex());
    if (!entry.topic->has_samples()) empty.insert_or_assign(entry.identity, key);
  }
  if (counts[identity] < kMostTopics - topics_.size()) return true;
  const auto most = std::ranges::max_element(
      empty, {}, [&](const auto& candidate) { return counts[candidate.first]; });
  if (most == empty.end() || counts[most->first] < counts[identity]) return false;
  topics_.erase(most->second);
  return true;
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
  for (const auto& [key, entry] : topics_) out += std::invoke(count, *entry.topic);
  return out;
}

std::uint64_t Keeper::without_key() const { return sum(&KeptTopic::without_key); }
std::uint64_t Keeper::dropped() const { return sum(&KeptTopic::dropped); }

}  // namespace ddssec::rtps
