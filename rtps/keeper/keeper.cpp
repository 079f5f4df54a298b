#include "rtps/keeper/keeper.hpp"

#include <algorithm>
#include <functional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/hash.hpp"
#include "rtps/dcps/context_access.hpp"
#include "rtps/discovery/serialized.hpp"
#include "rtps/durability/store_security.hpp"
#include "rtps/keeper/kept_topic.hpp"
#include "rtps/keeper/refused_writers.hpp"
#include "rtps/participant/rtps_participant.hpp"

namespace ddssec::rtps {
namespace {

// Returns the digest of topic, type, partitions and data tags. Names never contain a NUL, and topic
// names are not empty.
KeyHash key_of(const EndpointData& writer) {
  std::string text;
  const auto& tags = writer.qos.data_tags;
  if (!tags.empty()) text += '\0' + std::to_string(tags.size()) + '\0';
  for (const auto& tag : tags) text += tag.name + '\0' + tag.value + '\0';
  text += writer.topic_name + '\0' + writer.type_name;
  for (const auto& name : writer.qos.partition) text += '\0' + name;
  // Peers choose the names, so two topics must not have the same digest.
  const auto digest = sha256(as_bytes(text));
  KeyHash out;
  std::ranges::copy_n(digest.begin(), out.size(), out.begin());
  return out;
}

// Returns a stream that no writer can have, because topic names are not empty.
StreamKey stream_of_announcements(DomainId domain, const std::string& domain_tag) {
  StreamKey key{.domain = static_cast<std::uint32_t>(domain), .topic = "", .type = "kept"};
  if (!domain_tag.empty()) key.scope.push_back(domain_tag);
  return key;
}

// Refuses a writer that has only partitions with wildcards. A reader with these partitions would
// not match it: a name with wildcards matches only names without.
Status check_partition(const EndpointData& writer) {
  const auto& names = writer.qos.partition;
  if (partitions_match(names, names)) return {};
  return fail(Code::rtps_qos_incompatible,
              {.document = "topic " + writer.topic_name,
               .field = "PARTITION",
               .expected = "a name without wildcards, so that the keeper's reader matches",
               .found = fmt::format("\"{}\"", fmt::join(names, "\", \"")),
               .hint = "give its publisher a partition without wildcards as well"});
}

Change announcement(const EndpointData& writer, const KeyHash& key) {
  Change change;
  change.key_hash = key;
  change.payload = Payload::copy_of(serialized(writer));
  return change;
}

// False if the writer's announcement alone is the reason. Otherwise there may be room later, or the
// right when permissions are renewed.
bool may_succeed_later(const Error& error) { return error.code() != Code::rtps_qos_incompatible; }

// Returns the change that removes the remembered topic.
Change end_of_announcement(const KeyHash& key) {
  Change change;
  change.key_hash = key;
  change.is_key_only = true;
  change.status.disposed = true;
  return change;
}

Event kept_event(const EndpointData& writer, bool is_from_store) {
  auto where = fmt::format("topic {}, type {}", writer.topic_name, writer.type_name);
  if (!writer.qos.partition.empty())
    where += fmt::format(", partition {}", fmt::join(writer.qos.partition, ", "));
  if (is_from_store) where += " (from the store)";
  return Event(Error(Code::rtps_topic_kept, {.field = std::move(where)}));
}

Error no_room_error(const std::string& topic) {
  return Error(
      Code::rtps_store_failed,
      {.document = "keeper",
       .field = "topics",
       .expected =
           fmt::format("at most {}, and of one identity as many as are free", Keeper::kMaxTopics),
       .found = topic,
       .hint = "stop writers of other durable topics of the same identity, or name the topics to "
               "keep; this one is considered again once a second"});
}

}  // namespace

Result<std::unique_ptr<Keeper>> Keeper::create(DomainParticipantOptions options,
                                               KeeperOptions keeps,
                                               const PluginServices& services) {
  DDSSEC_ASSIGN_OR_RETURN(auto store,
                          DurableStore::open(keeps.store, services.events, keeps.store_octets,
                                             Time::from(services.clock.calendar_nanoseconds())));
  DDSSEC_RETURN_IF_ERROR(check_store_security(*store, options.security.has_value(),
                                              Time::from(services.clock.calendar_nanoseconds())));
  auto domain_tag = options.domain_tag;
  DDSSEC_ASSIGN_OR_RETURN(auto participant,
                          DomainParticipant::create(std::move(options), services));
  std::unique_ptr<Keeper> out(
      new Keeper(std::move(participant), std::move(store), std::move(keeps.topics)));
  out->domain_tag_ = std::move(domain_tag);
  DDSSEC_RETURN_IF_ERROR(out->start());
  return out;
}

Keeper::Keeper(std::unique_ptr<DomainParticipant> participant, std::unique_ptr<DurableStore> store,
               std::vector<std::string> topics)
    : participant_(std::move(participant)),
      context_(ContextAccess::of(*participant_)),
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
      store_->open_stream(stream_of_announcements(participant_->domain_id(), domain_tag_),
                          DurabilityService{}, context_.moment()));
  known_ = known.id;
  refused_ = std::make_unique<RefusedWriters>([this](const Guid& writer) { return retry(writer); });
  for (const auto& change : known.history) keep_known(change);
  auto* reader = participant_->builtin_datareader<PublicationBuiltinTopicData>();
  reader->set_listener(this, StatusKind::data_available);
  on_data_available(*reader);
  return {};
}

void Keeper::keep_known(const Change& announced) {
  const auto writer = read_publication_data(announced.payload.view());
  if (!writer || !wants(*writer)) return;
  const auto kept = keep(*writer, std::nullopt);
  if (kept) return;
  report(kept.error(), *writer);
  if (!may_succeed_later(kept.error())) return;
  {
    const std::lock_guard held(mutex_);
    refused_known_.emplace(writer->guid, *writer);
  }
  refused_->add(writer->guid, writer->guid.prefix);
}

void Keeper::report(const Error& error, const EndpointData& writer) const {
  auto details = error.details();
  if (!details.note.empty()) details.note += "; ";
  details.note += "topic " + writer.topic_name + " is not kept now";
  context_.services().events.raise(Event(Error(error.code(), std::move(details))));
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

std::optional<EndpointData> Keeper::wanted(const Guid& writer) const {
  const std::lock_guard lock(context_.mutex());
  const auto& remotes = context_.protocol().remote_participants();
  const auto* announced = remotes.endpoint(writer);
  if (announced == nullptr || !wants(*announced)) return std::nullopt;
  auto out = *announced;
  const auto& core = remotes.core();
  // All participants that did not authenticate are one identity, as in KeptTopic.
  const bool is_stranger = core.security && !core.is_authenticated(writer.prefix);
  out.guid.prefix = is_stranger ? GuidPrefix{} : core.identity_of(writer.prefix);
  return out;
}

bool Keeper::may_write(const Guid& writer) const {
  const std::lock_guard lock(context_.mutex());
  const auto& remotes = context_.protocol().remote_participants();
  const auto* announced = remotes.endpoint(writer);
  const auto& security = remotes.core().security;
  return announced != nullptr &&
         (!security || security->admission().may_write(Admission::Endpoint::of(*announced)));
}

void Keeper::consider(const Guid& writer) {
  const auto announced = wanted(writer);
  if (!announced) return;
  const auto& identity = announced->guid.prefix;
  if (!may_write(writer)) {
    refused_->add(writer, identity);
    return;
  }
  const auto kept = keep(*announced, writer);
  if (kept) return;
  if (may_succeed_later(kept.error()) && !refused_->add(writer, identity)) return;
  report(kept.error(), *announced);
}

bool Keeper::retry_known(const Guid& writer, const EndpointData& announced) {
  const auto kept = keep(announced, std::nullopt);
  if (!kept && may_succeed_later(kept.error())) return false;
  const std::lock_guard held(mutex_);
  refused_known_.erase(writer);
  return true;
}

bool Keeper::retry(const Guid& writer) {
  std::optional<EndpointData> known;
  {
    const std::lock_guard held(mutex_);
    if (const auto at = refused_known_.find(writer); at != refused_known_.end()) known = at->second;
  }
  if (known) return retry_known(writer, *known);
  const auto announced = wanted(writer);
  if (!announced) return true;
  if (!may_write(writer)) return false;
  const auto kept = keep(*announced, writer);
  return kept || !may_succeed_later(kept.error());
}

// A writer matches only if it may write. Until then, a writer of another identity that may also
// write, and announces other policies, determines how the topic is kept.
bool Keeper::is_settled(const KeyHash& key, const EndpointData& writer) const {
  const auto known = topics_.find(key);
  if (known == topics_.end()) return false;
  const auto& entry = known->second;
  const std::lock_guard lock(context_.mutex());
  return entry.topic->is_in_use() || entry.identity == writer.guid.prefix ||
         entry.topic->is_made_for(writer);
}

Status Keeper::keep(const EndpointData& writer, const std::optional<Guid>& announcer) {
  DDSSEC_RETURN_IF_ERROR(check_partition(writer));
  const auto key = key_of(writer);
  const auto& identity = writer.guid.prefix;
  const std::lock_guard held(mutex_);
  if (is_settled(key, writer)) return {};
  topics_.erase(key);
  if (announcer ? !make_room(identity) : topics_.size() >= kMaxTopics)
    return std::unexpected(no_room_error(writer.topic_name));
  const auto remember = [this, writer, key, announcer] {
    if (announcer) store_->append(known_, announcement(writer, key), context_.moment());
  };
  auto topic = std::make_unique<KeptTopic>(context_, *store_, held_, writer, remember);
  DDSSEC_RETURN_IF_ERROR(topic->open(participant_->domain_id(), domain_tag_));
  if (!announcer && !has_samples(*topic)) {
    store_->append(known_, end_of_announcement(key), context_.moment());
    return {};
  }
  topics_[key] = {std::move(topic), identity, announcer.value_or(Guid{})};
  context_.services().events.raise(kept_event(writer, !announcer));
  return {};
}

bool Keeper::has_samples(const KeptTopic& topic) const {
  const std::lock_guard lock(context_.mutex());
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
    const std::lock_guard lock(context_.mutex());
    const auto& remotes = context_.protocol().remote_participants();
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
  const std::lock_guard lock(context_.mutex());
  for (const auto& [prefix, remote] : context_.protocol().remote_participants().all())
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
    const std::lock_guard lock(context_.mutex());
    if (!entry.topic->has_samples()) empty.insert_or_assign(entry.identity, key);
  }
  if (counts[identity] < kMaxTopics - topics_.size()) return true;
  const auto most = std::ranges::max_element(
      empty, {}, [&](const auto& candidate) { return counts[candidate.first]; });
  if (most == empty.end() || counts[most->first] <= counts[identity]) return false;
  const auto found = topics_.find(most->second);
  const auto name = found->second.topic->name();
  topics_.erase(found);
  report_replaced(name);
  return true;
}

void Keeper::report_replaced(const std::string& name) {
  std::optional<EndpointData> any;
  for (const auto& writer : writers_on({name})) {
    const auto announced = wanted(writer);
    if (!announced) continue;
    any = announced;
    refused_->add(writer, announced->guid.prefix);
  }
  if (any) report(no_room_error(name), *any);
}

std::size_t Keeper::topics() const {
  const std::lock_guard held(mutex_);
  return topics_.size();
}

template <class Count>
std::uint64_t Keeper::sum(Count count) const {
  const std::lock_guard held(mutex_);
  const std::lock_guard lock(context_.mutex());
  std::uint64_t out = 0;
  for (const auto& [key, entry] : topics_) out += std::invoke(count, *entry.topic);
  return out;
}

std::uint64_t Keeper::without_key() const { return sum(&KeptTopic::without_key); }
std::uint64_t Keeper::dropped() const { return sum(&KeptTopic::dropped); }
std::uint64_t Keeper::left_out() const { return store_->left_out(); }

std::uint64_t Keeper::abandoned() const { return sum(&KeptTopic::abandoned); }

std::uint64_t Keeper::unstored() const { return store_->pending() + sum(&KeptTopic::waiting); }

std::uint64_t Keeper::served() const { return sum(&KeptTopic::served); }
std::uint64_t Keeper::served_octets() const { return sum(&KeptTopic::served_octets); }

}  // namespace ddssec::rtps
