#include "rtps/keeper/kept_topic.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "rtps/participant/rtps_participant.hpp"

namespace ddssec::rtps {
namespace {

// The approximate duration of a commit.
constexpr MonotonicTime kCommitPollInterval = std::chrono::milliseconds(5);
// How often changes that wait for an owner to come back are offered again.
constexpr MonotonicTime kDeferredPollInterval = std::chrono::milliseconds(100);
// How often to search for writers that have caught up.
constexpr MonotonicTime kLateWriterPollInterval = std::chrono::milliseconds(500);
// The shortest lease that a late joiner is offered, because assertions go to all participants for
// as long as the topic is kept.
constexpr Duration kMinLease{{1, 0}};

// Returns the policies of the original writer, so that every reader that matches it also matches
// this writer (unless it requests GROUP scope, or a lease of less than kMinLease). With OWNERSHIP
// EXCLUSIVE, this writer has the lowest strength. It has no limits of its own: DURABILITY_SERVICE
// limits what is stored, and only that is served.
Qos serving_qos(const Qos& original, Duration lifespan = kDurationInfinite) {
  auto qos = original;
  qos.lifespan = lifespan;
  qos.reliability.kind = ReliabilityKind::reliable;
  qos.history.kind = HistoryKind::keep_all;
  const auto most = std::numeric_limits<std::int32_t>::max();
  qos.resource_limits = {.max_samples = most, .max_samples_per_instance = most};
  qos.ownership_strength = std::numeric_limits<std::int32_t>::min();
  qos.liveliness.lease_duration = std::max(qos.liveliness.lease_duration, kMinLease);
  // Each sample is presented by itself, in the order in which it was stored.
  qos.presentation = {
      .scope = PresentationScope::topic, .coherent_access = true, .ordered_access = true};
  qos.user_data.clear();
  return qos;
}

Qos reading_qos(const Qos& original) {
  Qos qos;
  qos.reliability = original.reliability;
  qos.durability = DurabilityKind::transient;
  qos.history.kind = HistoryKind::keep_all;
  qos.ownership = original.ownership;
  qos.partition = original.partition;
  qos.data_representation = {DataRepresentation::xcdr1, DataRepresentation::xcdr2};
  return qos;
}

// Returns the values that separate streams in addition to their partitions; may be empty.
std::vector<std::string> scope_of(const std::string& domain_tag, const PropertyList& tags) {
  if (domain_tag.empty() && tags.empty()) return {};
  std::vector<std::string> out{domain_tag};
  for (const auto& tag : tags) out.insert(out.end(), {tag.name, tag.value});
  return out;
}

// Returns the LIFESPAN that is long enough for all these samples: none of them lives longer.
Duration lifespan_of(const DurableStore::OpenedStream& opened, const Moment& at) {
  auto out = kDurationZero;
  for (std::size_t i = 0; i < opened.history.size(); ++i) {
    const auto& change = opened.history[i];
    if (!change.is_alive()) continue;
    if (opened.expires[i] == kNever) return kDurationInfinite;
    const auto age =
        at.wall.to_nanoseconds() - change.source_time.value_or(at.wall).to_nanoseconds();
    out = std::max(out, Duration::from(opened.expires[i] - at.now + age));
  }
  return out;
}

RelayOrder relay_order(const Change& change, const Qos& qos) {
  if (change.origin().writer == change.writer) return RelayOrder::direct;
  return qos.destination_order == DestinationOrderKind::by_source ? RelayOrder::source_time
                                                                  : RelayOrder::number;
}

// Returns the LIFESPAN that the writer announces now.
Duration lifespan_of(const ParticipantContext& context, const Guid& writer) {
  const auto* announced = context.protocol().remote_participants().endpoint(writer);
  return announced == nullptr ? kDurationInfinite : announced->qos.lifespan;
}

}  // namespace

KeptTopic::KeptTopic(ParticipantContext& context, DurableStore& store,
                     std::shared_ptr<HeldOctets> held, EndpointData writer,
                     std::function<void()> on_first_sample)
    : TimedObject(&context.timers()),
      context_(context),
      store_(store),
      held_(std::move(held)),
      first_writer_(std::move(writer)),
      with_key_(has_key(first_writer_.guid.entity)),
      on_first_sample_(std::move(on_first_sample)) {}

KeptTopic::~KeptTopic() {
  const std::lock_guard held(context_.mutex());
  cancel();
  for (const auto& guid : {reader_, writer_})
    if (guid != Guid{}) context_.protocol().remove(guid, context_.now());
  context_.reschedule();
  if (stream_) store_.close_stream(*stream_);
}

Status KeptTopic::open(DomainId domain, const std::string& domain_tag) {
  StreamKey key{.domain = static_cast<std::uint32_t>(domain),
                .topic = first_writer_.topic_name,
                .type = first_writer_.type_name,
                .partition = first_writer_.qos.partition,
                .scope = scope_of(domain_tag, first_writer_.qos.data_tags)};
  const auto moment = context_.moment();
  DDSSEC_ASSIGN_OR_RETURN(
      auto opened,
      store_.open_stream(std::move(key), first_writer_.qos.durability_service, moment));
  longest_lifespan_ = std::max(first_writer_.qos.lifespan, lifespan_of(opened, moment));
  announced_lifespan_ = longest_lifespan_;
  stream_ = opened.id;
  const std::lock_guard held(context_.mutex());
  has_samples_ = !opened.history.empty();
  if (first_writer_.qos.ownership == OwnershipKind::exclusive) expect_owners(opened.history);
  for (const auto& change : opened.history) seen_.add(SeenOriginals::of(change));
  for (const auto& heard : opened.heard) heard_.emplace(heard.writer, heard);
  for (std::size_t i = 0; i < opened.rows.size(); ++i)
    rows_[opened.rows[i]] = {static_cast<std::int64_t>(i) + 1};
  auto serving = description_with(serving_qos(first_writer_.qos, longest_lifespan_));
  serving.history = std::move(opened.history);
  serving.is_history_only = true;
  const auto now = context_.now();
  DDSSEC_ASSIGN_OR_RETURN(writer_,
                          context_.protocol().create_writer(std::move(serving), *this, now));
  auto reading = description_with(reading_qos(first_writer_.qos));
  reading.held = held_;
  DDSSEC_ASSIGN_OR_RETURN(reader_,
                          context_.protocol().create_reader(std::move(reading), *this, now));
  context_.protocol().local_endpoints().reader(reader_)->acknowledge_before(
      [this](const Guid& from, SequenceNumber next) { return first_unstored(from, next); });
  schedule_next_call(now);
  context_.reschedule();
  return {};
}

EndpointDescription KeptTopic::description_with(Qos qos) const {
  return {.topic_name = first_writer_.topic_name,
          .type_name = first_writer_.type_name,
          .qos = std::move(qos),
          .with_key = with_key_,
          .type = first_writer_.type};
}

bool KeptTopic::is_made_for(const EndpointData& writer) const {
  return has_key(writer.guid.entity) == with_key_ && writer.type == first_writer_.type &&
         serving_qos(writer.qos) == serving_qos(first_writer_.qos) &&
         reading_qos(writer.qos) == reading_qos(first_writer_.qos);
}

void KeptTopic::expect_owners(const std::vector<Change>& history) {
  owners_.emplace(context_.now() + kReturn);
  for (const auto& change : history)
    owners_->expect(change.key_hash.value_or(KeyHash{}), change.origin().writer);
}

InstanceOwners::Claim KeptTopic::claim(const Change& change) {
  if (!owners_) return InstanceOwners::Claim::owned;
  return owners_->claim(change.key_hash.value_or(KeyHash{}), change.writer, context_.now());
}

bool KeptTopic::has_scope_of(const EndpointData& writer) const {
  return writer.qos.partition == first_writer_.qos.partition &&
         writer.qos.data_tags == first_writer_.qos.data_tags;
}

// The reader matches every writer with a partition in common. A sample of a writer that is not kept
// here is acknowledged and dropped.
bool KeptTopic::on_change(Change& change) {
  using Claim = InstanceOwners::Claim;
  if (change.is_marker() || !writers_.contains(change.writer)) return true;
  const auto expires =
      end_of_life(change.source_time, lifespan_of(context_, change.writer), context_.moment());
  // A sample that another keeper relays may be missing here: its writer may hold less than the
  // service does.
  const bool is_direct = change.origin().writer == change.writer;
  if (seen_.contains(change, expires) || (is_direct && was_heard(change))) {
    if (is_direct) claim(change);  // the owner of a stored instance came back
    return true;
  }
  if (with_key_ && !change.key_hash) {
    ++without_key_;
    return true;
  }
  if (!identity_of(change.writer.prefix) && store_.is_behind()) return defer(context_.now());
  const auto claimed = claim(change);
  if (claimed == Claim::no_room) {
    if (const auto identity = identity_of(change.writer.prefix)) store_.refuse(*identity);
    return wait_for_room(change.writer, true);
  }
  if (claimed == Claim::later) return defer(context_.now());
  return claimed == Claim::refused || keep(change);
}

bool KeptTopic::wait_for_room(const Guid& writer, bool has_no_share) {
  have_waited_.insert(writer);
  if (has_no_share) without_share_.insert(writer);
  return defer(context_.now());
}

bool KeptTopic::defer(MonotonicTime now) {
  has_deferred_ = true;
  schedule_next_call(now);
  return false;
}

// True if the change was heard before the keeper was restarted. A writer that was restarted and has
// the same GUID begins again with the number 1, and later timestamps.
bool KeptTopic::was_heard(const Change& change) const {
  const auto origin = change.origin();
  const auto at = heard_.find(origin.writer);
  return at != heard_.end() && change.source_time && origin.number <= at->second.number &&
         *change.source_time <= at->second.time;
}

bool KeptTopic::keep(Change& change) {
  const auto moment = context_.moment();
  const auto [now, wall] = moment;
  change.original = change.origin();
  change.coherence = {};
  if (!change.source_time) change.source_time = wall;
  const auto writer = change.writer;
  const auto original = change.sequence_number;
  const auto lifespan = lifespan_of(context_, writer);
  extend_lifespan(lifespan);
  discard(store_.clean_up(*stream_, moment));
  const auto kept = store_.append({.stream = *stream_,
                                   .change = change,
                                   .identity = identity_of(writer.prefix),
                                   .is_late = have_waited_.contains(writer),
                                   .is_remembered = change.original.writer == writer,
                                   .relay_order = relay_order(change, first_writer_.qos),
                                   .lifespan = lifespan},
                                  moment);
  if (kept.outcome.decision == SampleIndex::Decision::waits)
    return wait_for_room(writer, kept.has_no_share);
  seen_.add(SeenOriginals::of(change, end_of_life(change.source_time, lifespan, moment)));
  if (!std::exchange(has_samples_, true)) on_first_sample_();
  if (owners_ && change.status.unregistered)
    owners_->release(change.key_hash.value_or(KeyHash{}), writer);
  unstored_[writer].push_back({kept.number, original});
  discard(kept.outcome.removed);
  if (kept.outcome.row != 0) rows_[kept.outcome.row] = server().write(change, now);
  schedule_next_call(now);
  return true;
}

// Without security there are no identities. All participants that did not authenticate count as
// one identity.
std::optional<GuidPrefix> KeptTopic::identity_of(const GuidPrefix& sender) const {
  const auto& core = context_.protocol().remote_participants().core();
  if (!core.security) return std::nullopt;
  return core.is_authenticated(sender) ? core.identity_of(sender) : GuidPrefix{};
}

void KeptTopic::on_matched(const EndpointData& remote) {
  if (!is_writer(remote.guid.entity)) return;
  if (!has_scope_of(remote)) return on_unmatched(remote.guid);
  writers_.insert(remote.guid);
  extend_lifespan(remote.qos.lifespan);
  if (!owners_) return;
  const auto identity = identity_of(remote.guid.prefix);
  owners_->set_writer(remote.guid, remote.qos.ownership_strength, identity);
  const auto now = context_.now();
  liveliness_.add(remote.guid, remote.qos.liveliness.lease_duration, now, identity);
  schedule_next_call(now);
}

void KeptTopic::extend_lifespan(Duration lifespan) {
  if (lifespan <= longest_lifespan_) return;
  longest_lifespan_ = lifespan;
  schedule_next_call(context_.now());
}

void KeptTopic::on_unmatched(const Guid& remote) {
  writers_.erase(remote);
  have_waited_.erase(remote);
  without_share_.erase(remote);
  if (!owners_) return;
  owners_->remove_writer(remote);
  liveliness_.remove(remote);
}

void KeptTopic::on_signal(const Guid& writer, std::shared_ptr<LivelinessSignal> signal) {
  if (!owners_ || !writers_.contains(writer)) return;
  if (signal && !liveliness_.is_alive(writer)) signal->notify(*this, writer);
  liveliness_.follow(writer, std::move(signal));
  schedule_next_call(context_.now());
}

void KeptTopic::on_alive(const Guid& writer) {
  if (!owners_ || !writers_.contains(writer)) return;
  const auto now = context_.now();
  liveliness_.note_alive(writer, now);
  schedule_next_call(now);
}

SequenceNumber KeptTopic::first_unstored(const Guid& writer, SequenceNumber next) const {
  const auto at = unstored_.find(writer);
  return at == unstored_.end() ? next : at->second.front().change;
}

StatefulWriter& KeptTopic::server() const {
  return *context_.protocol().local_endpoints().writer(writer_);
}

std::uint64_t KeptTopic::waiting() const {
  const auto* reader = context_.protocol().local_endpoints().reader(reader_);
  return reader == nullptr ? 0 : reader->refused().waiting;
}

std::uint64_t KeptTopic::abandoned() const {
  const auto* reader = context_.protocol().local_endpoints().reader(reader_);
  return reader == nullptr ? 0 : reader->refused().abandoned;
}

std::uint64_t KeptTopic::served() const { return server().history().size(); }
std::uint64_t KeptTopic::served_octets() const { return server().history().octets(); }

void KeptTopic::discard(const std::vector<std::int64_t>& rows) {
  for (const auto row : rows)
    if (const auto gone = rows_.extract(row)) server().discard(gone.mapped());
}

void KeptTopic::schedule_next_call(MonotonicTime now) {
  auto next = liveliness_.next_tick();
  if (has_deferred_) next = std::min(next, now + kDeferredPollInterval);
  const auto due = unstored_.empty() ? store_.next_due(*stream_) : now;
  if (announced_lifespan_ != longest_lifespan_) next = now;
  call_at(std::min(next, std::max(due, now + kCommitPollInterval)));
}

void KeptTopic::on_time(MonotonicTime now) {
  // The announcement is changed here, because it cannot be while endpoints are being matched. It
  // cannot be refused: LIFESPAN is neither matched nor immutable.
  if (std::exchange(announced_lifespan_, longest_lifespan_) != longest_lifespan_) {
    [[maybe_unused]] const auto changed = context_.protocol().change_qos(
        writer_, serving_qos(first_writer_.qos, longest_lifespan_), now);
  }
  liveliness_.expire(now, [&](const Guid& writer, LivelinessSignal* signal) {
    if (signal != nullptr) signal->notify(*this, writer);
    owners_->note_lease_ended(writer);
  });
  discard(store_.clean_up(*stream_, context_.moment()));
  const bool has_news = acknowledge_stored();
  auto* reader = context_.protocol().local_endpoints().reader(reader_);
  request_waiting_samples(now);
  if ((std::exchange(has_deferred_, false) || has_news) && reader != nullptr) reader->offer_again();
  schedule_next_call(now);
}

void KeptTopic::request_waiting_samples(MonotonicTime now) {
  auto* reader = context_.protocol().local_endpoints().reader(reader_);
  if (reader == nullptr) return;
  if (!without_share_.empty() && pace_.is_due(now)) {
    std::size_t octets = 0;
    for (const auto& writer : std::exchange(without_share_, {}))
      octets += reader->request_refused(writer);
    pace_.note_requested(octets, now);
  }
  if (now < next_late_check_) return;
  next_late_check_ = now + kLateWriterPollInterval;
  std::erase_if(have_waited_, [&](const Guid& writer) {
    const auto* const proxy = reader->writer(writer);
    return proxy == nullptr || proxy->has_caught_up();
  });
}

bool KeptTopic::acknowledge_stored() {
  const auto stored = store_.committed();
  auto* reader = context_.protocol().local_endpoints().reader(reader_);
  bool has_news = false;
  for (auto at = unstored_.begin(); at != unstored_.end();) {
    const auto writer = at->first;
    auto& queue = at->second;
    const bool is_news = queue.front().number <= stored;
    while (!queue.empty() && queue.front().number <= stored) queue.pop_front();
    at = queue.empty() ? unstored_.erase(at) : std::next(at);
    if (is_news && reader != nullptr) reader->acknowledge_again(writer);
    has_news = has_news || is_news;
  }
  return has_news;
}

void KeptTopic::on_sample_dropped(const Guid& writer, std::uint32_t octets) {
  if (!writers_.contains(writer)) return;
  ++dropped_;
  context_.protocol().remote_participants().raise_about(
      Error(Code::rtps_sample_dropped,
            {.document = "topic " + first_writer_.topic_name,
             .field = "serialized size",
             .expected = fmt::format("at most {}", StatefulReader::kMaxSample),
             .found = std::to_string(octets)}),
      reader_.entity, writer);
}

}  // namespace ddssec::rtps
