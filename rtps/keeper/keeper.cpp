#include "rtps/keeper/keeper.hpp"

#include <algorithm>
#include <functional>

#include <fmt/format.h>

#include "base/hash.hpp"
#include "rtps/keeper/kept_topic.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::size_t kMostAnnouncement = 64 << 10;

/// Digest of topic, type and partitions; names never contain a NUL.
KeyHash key_of(const EndpointData& writer) {
  auto text = writer.topic_name + '\0' + writer.type_name;
  for (const auto& name : writer.qos.partition) text += '\0' + name;
  return md5(as_bytes(text));
}

/// A stream that no writer can have, because topic names are not empty.
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

/// Removes what was remembered of the topic.
Change end_of_announcement(const KeyHash& key) {
  Change change;
  change.key_hash = key;
  change.key_only = true;
  change.status.disposed = true;
  return change;
}

}  // namespace

Result<std::unique_ptr<Keeper>> Keeper::create(DomainParticipantOptions options,
                                               KeeperOptions keeps,
                                               const Environment& environment) {
  DDSSEC_ASSIGN_OR_RETURN(auto store,
                          DurableStore::open(keeps.store, environment.events, keeps.store_octets));
  DDSSEC_ASSIGN_OR_RETURN(auto participant,
                          DomainParticipant::create(std::move(options), environment));
  std::unique_ptr<Keeper> out(
      new Keeper(std::move(participant), std::move(store), std::move(keeps.topics)));
  DDSSEC_RETURN_IF_ERROR(out->start());
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
  DDSSEC_RETURN_IF_ERROR(participant_->ignore_participant(participant_->guid()));
  DDSSEC_ASSIGN_OR_RETURN(
      auto known,
      store_->open_stream(stream_of_announcements(participant_->domain_id()), DurabilityService{}));
  known_ = known.id;
  for (const auto& change : known.history) DDSSEC_RETURN_IF_ERROR(keep_known(change));
  auto* reader = participant_->builtin_datareader<PublicationBuiltinTopicData>();
  reader->set_listener(this, StatusKind::data_available);
  on_data_available(*reader);
  return {};
}

Status Keeper::keep_known(const Change& announced) {
  const auto writer = read_publication_data(announced.payload.view());
  if (!writer) return {};
  const auto kept = keep(*writer, std::nullopt);
  // A topic without a place must not prevent others from being served.
  if (kept || kept.error().code() != Code::rtps_store_failed) return kept;
  participant_->context_.environment().events.raise(Event(kept.error()));
  return {};
}

void Keeper::on_data_available(AnyDataReader& any) {
  auto& reader = static_cast<BuiltinDataReader<PublicationBuiltinTopicData>&>(any);
  std::vector<BuiltinSample<PublicationBuiltinTopicData>> found;
  if (!reader.take(found)) return;
  bool any_gone = false;
  for (const auto& [writer, info] : found) {
    any_gone = any_gone || !info.valid_data;
    if (info.valid_data && wants(writer)) consider(writer.guid);
  }
  if (any_gone) replace_abandoned();
}

bool Keeper::wants(const EndpointData& writer) const {
  return writer.qos.durability >= DurabilityKind::transient &&
         std::ranges::any_of(patterns_, [&](const auto& pattern) {
           return glob_match(pattern, writer.topic_name);
         });
}

std::optional<EndpointData> Keeper::admitted(const Guid& writer) const {
  auto& context = participant_->context_;
  const std::lock_guard lock(context.mutex());
  const auto& remotes = context.protocol().remote_participants();
  const auto* announced = remotes.endpoint(writer);
  if (announced == nullptr || !wants(*announced)) return std::nullopt;
  const auto& security = remotes.core().security;
  if (security && !security->may_write(Admission::Endpoint::of(*announced))) return std::nullopt;
  auto out = *announced;
  out.guid.prefix = remotes.core().identity_of(writer.prefix);
  return out;
}

void Keeper::consider(const Guid& writer) {
  const auto announced = admitted(writer);
  if (!announced) return;
  if (const auto kept = keep(*announced, writer); !kept)
    participant_->context_.environment().events.raise(Event(kept.error()));
}

// A writer matches only if it may write. Until then, a writer of another identity that may also
// write, and announces other policies, determines how the topic is kept.
bool Keeper::is_settled(const KeyHash& key, const EndpointData& writer) const {
  const auto known = topics_.find(key);
  if (known == topics_.end()) return false;
  const auto& entry = known->second;
  const std::lock_guard lock(participant_->context_.mutex());
  return entry.topic->is_in_use() || entry.identity == writer.guid.prefix ||
         entry.topic->is_made_for(writer);
}

Status Keeper::keep(const EndpointData& writer, const std::optional<Guid>& announcer) {
  const auto key = key_of(writer);
  const auto& identity = writer.guid.prefix;
  const std::lock_guard held(mutex_);
  auto& context = participant_->context_;
  if (is_settled(key, writer)) return {};
  topics_.erase(key);
  if (announcer ? !make_room(identity) : topics_.size() >= kMostTopics)
    return fail(Code::rtps_store_failed,
                {.document = "keeper",
                 .field = "topics",
                 .expected = fmt::format("at most {}, and of one identity as many as are free",
                                         kMostTopics),
                 .found = writer.topic_name});
  const auto remember = [this, writer, key, announcer] {
    if (announcer)
      store_->append(known_, announcement(writer, key), participant_->context_.moment().wall);
  };
  auto topic = std::make_unique<KeptTopic>(context, *store_, writer, remember);
  DDSSEC_RETURN_IF_ERROR(topic->open(participant_->domain_id()));
  if (!announcer && !has_samples(*topic)) {
    store_->append(known_, end_of_announcement(key), context.moment().wall);
    return {};
  }
  topics_[key] = {std::move(topic), identity, announcer.value_or(Guid{})};
  return {};
}

bool Keeper::has_samples(const KeptTopic& topic) const {
  const std::lock_guard lock(participant_->context_.mutex());
  return topic.has_samples();
}

void Keeper::replace_abandoned() {
  const auto names = remove_abandoned();
  if (names.empty()) return;
  for (const auto& writer : writers_on(names)) consider(writer);
}

std::set<std::string> Keeper::remove_abandoned() {
  const std::lock_guard held(mutex_);
  std::set<std::string> names;
  std::vector<KeyHash> keys;
  {
    const std::lock_guard lock(participant_->context_.mutex());
    const auto& remotes = participant_->context_.protocol().remote_participants();
    for (const auto& [key, entry] : topics_) {
      if (entry.topic->is_in_use() || remotes.endpoint(entry.announcer) != nullptr) continue;
      names.insert(entry.topic->name());
      keys.push_back(key);
    }
  }
  for (const auto& key : keys) topics_.erase(key);  // their destructors take the lock
  return names;
}

std::vector<Guid> Keeper::writers_on(const std::set<std::string>& topics) const {
  std::vector<Guid> out;
  const std::lock_guard lock(participant_->context_.mutex());
  for (const auto& [prefix, remote] : participant_->context_.protocol().remote_participants().all())
    for (const auto& [id, endpoint] : remote.endpoints)
      if (is_writer(id) && topics.contains(endpoint.data.topic_name))
        out.push_back(endpoint.data.guid);
  return out;
}

bool Keeper::make_room(const GuidPrefix& identity) {
  std::map<GuidPrefix, std::size_t> counts;
  std::map<GuidPrefix, KeyHash> empty;  // for each identity, one topic without samples
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
std::uint64_t Keeper::left_out() const { return store_->left_out() + sum(&KeptTopic::left_out); }
std::uint64_t Keeper::served() const { return sum(&KeptTopic::served); }
std::uint64_t Keeper::served_octets() const { return sum(&KeptTopic::served_octets); }

}  // namespace ddssec::rtps
