#include "rtps/keeper/kept_topic.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

namespace ddssec::rtps {
namespace {

// A commit takes about this long.
constexpr MonotonicTime kLook = std::chrono::milliseconds(5);
// How often samples are looked for that the store removes later.
constexpr MonotonicTime kRareLook = std::chrono::seconds(1);
// How often changes are offered again that wait for an owner to come back.
constexpr MonotonicTime kDeferredLook = std::chrono::milliseconds(100);
// What a late joiner is offered at least, because assertions go to all participants for as long as
// the topic is kept.
constexpr Duration kLeastLease{{1, 0}};

// The policies of the original writer, so that every reader that matches it also matches this
// writer (unless it requests a lease of less than kLeastLease). With OWNERSHIP EXCLUSIVE, this
// writer has the lowest strength. It has no limits of its own: DURABILITY_SERVICE limits what is
// stored, and only that is served.
Qos serving_qos(const Qos& original) {
  auto qos = original;
  qos.reliability.kind = ReliabilityKind::reliable;
  qos.history.kind = HistoryKind::keep_all;
  const auto most = std::numeric_limits<std::int32_t>::max();
  qos.resource_limits = {.max_samples = most, .max_samples_per_instance = most};
  qos.ownership_strength = std::numeric_limits<std::int32_t>::min();
  qos.liveliness.lease_duration = std::max(qos.liveliness.lease_duration, kLeastLease);
  qos.presentation = {};
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

/// What separates streams besides their partitions. Empty: nothing.
std::vector<std::string> scope_of(const std::string& domain_tag, const spi::PropertyList& tags) {
  if (domain_tag.empty() && tags.empty()) return {};
  std::vector<std::string> out{domain_tag};
  for (const auto& tag : tags) out.insert(out.end(), {tag.name, tag.value});
  return out;
}

}  // namespace

KeptTopic::KeptTopic(ParticipantContext& context, DurableStore& store, EndpointData writer,
                     std::function<void()> on_first_sample)
    : Timed(&context.timers()),
      context_(context),
      store_(store),
      like_(std::move(writer)),
      with_key_(has_key(like_.guid.entity)),
      on_first_sample_(std::move(on_first_sample)) {}

KeptTopic::~KeptTopic() {
  const std::lock_guard held(context_.mutex());
  cancel();
  for (const auto& guid : {reader_, writer_})
    if (guid != Guid{}) context_.protocol().remove(guid, context_.now());
  context_.reschedule();
  for (const auto* list : {&refused_, &unstored_})
    for (const auto& one : *list)
      if (one.state == Unstored::State::refused) store_.give_up_refused(*one.identity);
  if (stream_) store_.close_stream(*stream_);
}

Status KeptTopic::open(DomainId domain, const std::string& domain_tag) {
  StreamKey key{.domain = static_cast<std::uint32_t>(domain),
                .topic = like_.topic_name,
                .type = like_.type_name,
                .partition = like_.qos.partition,
                .scope = scope_of(domain_tag, like_.qos.data_tags)};
  DDSSEC_ASSIGN_OR_RETURN(auto opened,
                          store_.open_stream(std::move(key), like_.qos.durability_service, true));
  stream_ = opened.id;
  const std::lock_guard held(context_.mutex());
  has_samples_ = !opened.history.empty();
  if (like_.qos.ownership == OwnershipKind::exclusive) expect_owners(opened.history);
  for (const auto& change : opened.history) seen_.add(SeenOriginals::of(change));
  for (std::size_t i = 0; i < opened.rows.size(); ++i)
    rows_[opened.rows[i]] = {static_cast<std::int64_t>(i) + 1};
  auto serving = request(serving_qos(like_.qos));
  serving.history = std::move(opened.history);
  serving.history_only = true;
  const auto now = context_.now();
  DDSSEC_ASSIGN_OR_RETURN(writer_,
                          context_.protocol().create_writer(std::move(serving), *this, now));
  DDSSEC_ASSIGN_OR_RETURN(
      reader_, context_.protocol().create_reader(request(reading_qos(like_.qos)), *this, now));
  context_.protocol().local_endpoints().reader(reader_)->acknowledge_before(
      [this](const Guid& from, SequenceNumber next) { return first_unstored(from, next); });
  look_again(now);
  context_.reschedule();
  return {};
}

EndpointRequest KeptTopic::request(Qos qos) const {
  return {.topic_name = like_.topic_name,
          .type_name = like_.type_name,
          .qos = std::move(qos),
          .with_key = with_key_,
          .type = like_.type};
}

bool KeptTopic::is_made_for(const EndpointData& writer) const {
  return has_key(writer.guid.entity) == with_key_ && writer.type == like_.type &&
         serving_qos(writer.qos) == serving_qos(like_.qos) &&
         reading_qos(writer.qos) == reading_qos(like_.qos);
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
  return writer.qos.partition == like_.qos.partition && writer.qos.data_tags == like_.qos.data_tags;
}

// The reader matches every writer with a partition in common. What such a writer sends is
// acknowledged here and not kept.
bool KeptTopic::on_change(Change& change) {
  using Claim = InstanceOwners::Claim;
  if (change.is_marker() || !writers_.contains(change.writer)) return true;
  if (seen_.contains(change)) {
    // The owner of a stored instance came back.
    if (change.origin().writer == change.writer) claim(change);
    return true;
  }
  if (with_key_ && !change.key_hash) {
    ++without_key_;
    return true;
  }
  if (store_.is_behind()) return false;  // the writer offers it again
  const auto identity = identity_of(change.writer.prefix);
  if (is_crowded(identity)) return defer(context_.now());
  const auto claimed = claim(change);
  if (claimed == Claim::no_room) ++left_out_;
  if (claimed == Claim::owned) keep(change, identity);
  return claimed != Claim::later || defer(context_.now());
}

bool KeptTopic::defer(MonotonicTime now) {
  deferred_ = true;
  look_again(now);
  return false;
}

bool KeptTopic::is_crowded(const std::optional<GuidPrefix>& identity) const {
  return identity && (store_.is_crowded(*identity) || store_.has_refused(*identity));
}

void KeptTopic::keep(Change& change, const std::optional<GuidPrefix>& identity) {
  seen_.add(SeenOriginals::of(change));
  if (!std::exchange(has_samples_, true)) on_first_sample_();
  change.original = change.origin();
  change.coherence = {};
  const auto [now, wall] = context_.moment();
  if (!change.source_time) change.source_time = wall;
  const auto number = store_.append(*stream_, change, wall, identity);
  const auto writer = change.writer;
  const auto original = change.sequence_number;
  if (owners_ && change.status.unregistered)
    owners_->release(change.key_hash.value_or(KeyHash{}), writer);
  unstored_.push_back({number, writer, original, server().write(change, now), identity});
  look_again(now);
}

/// Without security there are no identities. All participants that did not authenticate count as
/// one identity.
std::optional<GuidPrefix> KeptTopic::identity_of(const GuidPrefix& sender) const {
  const auto& core = context_.protocol().remote_participants().core();
  if (!core.security) return std::nullopt;
  return core.is_authenticated(sender) ? core.identity_of(sender) : GuidPrefix{};
}

void KeptTopic::on_matched(const EndpointData& remote) {
  if (!is_writer(remote.guid.entity)) return;
  if (!has_scope_of(remote)) return on_unmatched(remote.guid);
  writers_.insert(remote.guid);
  if (!owners_) return;
  owners_->set_writer(remote.guid, remote.qos.ownership_strength, identity_of(remote.guid.prefix));
  const auto now = context_.now();
  liveliness_.add(remote.guid, remote.qos.liveliness.lease_duration, now);
  look_again(now);
}

void KeptTopic::on_unmatched(const Guid& remote) {
  writers_.erase(remote);
  if (!owners_) return;
  owners_->remove_writer(remote);
  liveliness_.remove(remote);
}

void KeptTopic::on_signal(const Guid& writer, std::shared_ptr<LivelinessSignal> signal) {
  if (!owners_ || !writers_.contains(writer)) return;
  if (signal && !liveliness_.is_alive(writer)) signal->notify(*this, writer);
  liveliness_.follow(writer, std::move(signal));
  look_again(context_.now());
}

void KeptTopic::on_alive(const Guid& writer) {
  if (!owners_ || !writers_.contains(writer)) return;
  const auto now = context_.now();
  liveliness_.alive(writer, now);
  look_again(now);
}

SequenceNumber KeptTopic::first_unstored(const Guid& writer, SequenceNumber next) {
  if (const auto at = first_refused_.find(writer); at != first_refused_.end()) return at->second;
  const auto at = std::ranges::find(unstored_, writer, &Unstored::writer);
  return at == unstored_.end() ? next : at->change;
}

StatefulWriter& KeptTopic::server() const {
  return *context_.protocol().local_endpoints().writer(writer_);
}

std::uint64_t KeptTopic::waiting() const {
  const auto* reader = context_.protocol().local_endpoints().reader(reader_);
  return refused_.size() + (reader == nullptr ? 0 : reader->refused());
}

std::uint64_t KeptTopic::abandoned() const {
  const auto* reader = context_.protocol().local_endpoints().reader(reader_);
  return reader == nullptr ? 0 : reader->abandoned();
}

std::uint64_t KeptTopic::served() const { return server().history().size(); }
std::uint64_t KeptTopic::served_octets() const { return server().history().octets(); }

void KeptTopic::serve(const std::vector<StoreEffect>& effects) {
  auto& writer = server();
  for (const auto& effect : effects) {
    if (effect.stored == 0) {
      if (const auto gone = rows_.extract(effect.row)) writer.discard(gone.mapped());
      continue;
    }
    const auto at = std::ranges::lower_bound(unstored_, effect.stored, {}, &Unstored::number);
    if (at == unstored_.end() || at->number != effect.stored) continue;
    at->state = effect.is_refused ? Unstored::State::refused : Unstored::State::stored;
    if (!effect.is_refused) rows_[effect.row] = at->served;
  }
}

// What is disposed is removed from the store after service_cleanup_delay, by any later commit.
void KeptTopic::look_again(MonotonicTime now) {
  const auto delay = like_.qos.durability_service.cleanup_delay;
  auto next = liveliness_.next_tick();
  if (deferred_) next = std::min(next, now + kDeferredLook);
  if (!unstored_.empty())
    next = std::min(next, now + kLook);
  else if (!rows_.empty() && delay != kDurationZero && !delay.is_infinite())
    next = std::min(next, now + kRareLook);
  call_at(next);
}

void KeptTopic::on_time(MonotonicTime now) {
  liveliness_.check(now, [&](const Guid& writer, LivelinessSignal* signal) {
    if (signal != nullptr) signal->notify(*this, writer);
    owners_->lose(writer);
  });
  const auto stored = store_.committed();
  serve(store_.take_effects(*stream_));
  std::set<Guid> writers;
  for (; !unstored_.empty() && unstored_.front().number <= stored; unstored_.pop_front()) {
    writers.insert(unstored_.front().writer);
    using enum Unstored::State;
    if (unstored_.front().state == under_way) server().discard(unstored_.front().served);
    if (unstored_.front().state != refused) continue;
    first_refused_.try_emplace(unstored_.front().writer, unstored_.front().change);
    refused_.push_back(std::move(unstored_.front()));
  }
  auto* reader = context_.protocol().local_endpoints().reader(reader_);
  const bool deferred = std::exchange(deferred_, false);
  if ((deferred || !writers.empty()) && reader != nullptr) {
    reader->offer_again();
    for (const auto& writer : writers) reader->acknowledge_again(writer);
  }
  store_refused();
  look_again(now);
}

// All of an identity together, after all that it sent before: so they keep their order.
void KeptTopic::store_refused() {
  if (refused_.empty()) return;
  deferred_ = true;
  const auto moment = context_.moment();
  if (moment.now < next_retry_) return;
  next_retry_ = moment.now + kRareLook;
  store_.look_for_room(moment.wall);
  std::set<std::optional<GuidPrefix>> ready;
  for (const auto& one : refused_)
    if (!store_.is_crowded(*one.identity)) ready.insert(one.identity);
  for (const auto& one : unstored_) ready.erase(one.identity);
  std::erase_if(refused_, [&](Unstored& one) {
    if (!ready.contains(one.identity)) return false;
    const auto* change = server().history().find(one.served);
    // A later sample of the instance may have replaced it.
    if (change == nullptr) return store_.give_up_refused(*one.identity), true;
    one.number = store_.append(*stream_, *change, moment.wall, one.identity, true);
    one.state = Unstored::State::under_way;
    unstored_.push_back(one);
    return true;
  });
  first_refused_.clear();
  for (const auto& one : refused_) first_refused_.try_emplace(one.writer, one.change);
}

void KeptTopic::on_sample_dropped(const Guid& writer, std::uint32_t octets) {
  if (!writers_.contains(writer)) return;
  ++dropped_;
  context_.protocol().remote_participants().raise_about(
      Error(Code::rtps_sample_dropped,
            {.document = "topic " + like_.topic_name,
             .field = "serialized size",
             .expected = fmt::format("at most {}", StatefulReader::kLargestSample),
             .found = std::to_string(octets)}),
      reader_.entity, writer);
}

}  // namespace ddssec::rtps
