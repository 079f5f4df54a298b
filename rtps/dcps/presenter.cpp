#include "rtps/dcps/presenter.hpp"

#include <algorithm>

namespace ddssec::rtps {

void Presenter::add_writer(PresentedReader& reader, const Guid& writer,
                           const std::optional<Guid>& group, const GuidPrefix& identity) {
  const bool grouped = access_.is_by_group && group;
  const SourceKey key{grouped ? nullptr : &reader, grouped ? *group : writer};
  if (!source_of_.try_emplace({&reader, writer}, key).second) return;
  auto& source = sources_[key];
  source.key = key;
  if (source.streams.empty() && source.ready.empty()) source.identity = identity;
  source.streams.try_emplace({&reader, writer});
  source.leaving.erase({&reader, writer});  // the writer is back
}

bool Presenter::remove_writer(PresentedReader& reader, const Guid& writer, MonotonicTime now) {
  const StreamKey key{&reader, writer};
  const auto known = source_of_.extract(key);
  if (!known) return false;
  const auto at = sources_.find(known.mapped());
  auto& source = at->second;
  source.streams.erase(key);
  for (auto next = source.sets.begin(); next != source.sets.end();) {
    auto& [id, set] = *next++;
    const auto is_its = [&](const Item& item) {
      return item.reader == &reader && item.change.writer == writer;
    };
    set.is_broken =
        set.is_broken || (!set.ended.contains(key) && std::ranges::any_of(set.items, is_its));
    set.ended.erase(key);
    finish_if_complete(source, id, now);
  }
  present_ready_of(source, now);
  const bool waits = starts_leaving(source, key);
  forget_if_done(at);
  return waits;
}

bool Presenter::starts_leaving(Source& source, const StreamKey& key) {
  std::size_t items = 0;
  for (const auto& [id, batch] : source.ready)
    items += static_cast<std::size_t>(std::ranges::count_if(batch.items, [&](const Item& item) {
      return item.reader == key.first && item.change.writer == key.second;
    }));
  if (items > 0) source.leaving[key] = items;
  return items > 0;
}

void Presenter::note_presented(Source& source, const StreamKey& key) {
  const auto at = source.leaving.find(key);
  if (at == source.leaving.end() || --at->second > 0) return;
  source.leaving.erase(at);
  key.first->note_left(key.second);
}

// Returns an iterator to the next source.
std::map<Presenter::SourceKey, Presenter::Source>::iterator Presenter::forget_if_done(
    std::map<SourceKey, Source>::iterator at) {
  auto& source = at->second;
  if (!source.streams.empty()) return std::next(at);
  while (!source.sets.empty()) remove_set(source, source.sets.begin());
  return source.ready.empty() ? sources_.erase(at) : std::next(at);
}

void Presenter::remove_reader(PresentedReader& reader, MonotonicTime now) {
  const auto is_its = [&](const Item& item) { return item.reader == &reader; };
  for (auto& [key, source] : sources_) {
    for (auto& [id, set] : source.sets)
      std::erase_if(set.items, [&, &from = source, &in = set](const Item& item) {
        if (is_its(item)) refund_open(from, in, price_of(item));
        return is_its(item);
      });
    for (auto& [id, batch] : source.ready)
      std::erase_if(batch.items, [&, &from = source](const Item& item) {
        if (is_its(item)) refund_ready(from, price_of(item));
        return is_its(item);
      });
    for (auto& [id, batch] : source.ready) batch.wanted.erase(&reader);
    std::erase_if(source.ready, [](const auto& entry) { return entry.second.items.empty(); });
    std::erase_if(source.leaving, [&](const auto& entry) { return entry.first.first == &reader; });
  }
  std::vector<Guid> writers;
  for (const auto& [key, source] : source_of_)
    if (key.first == &reader) writers.push_back(key.second);
  for (const auto& writer : writers) remove_writer(reader, writer, now);
  present_ready(now);  // other readers may have waited for this one
}

Presenter::Source* Presenter::find(PresentedReader& reader, const Guid& writer) {
  const auto at = source_of_.find({&reader, writer});
  return at == source_of_.end() ? nullptr : &sources_[at->second];
}

bool Presenter::on_change(PresentedReader& reader, Change& change, MonotonicTime now) {
  auto* source = find(reader, change.writer);
  if (source == nullptr) return true;  // the writer is no longer matched
  if (!make_room(*source)) return false;
  add_to_set(*source, {&reader, change.writer}, change, now);
  present_ready_of(*source, now);
  make_room(*source);
  return true;
}

void Presenter::charge_open(const Source& source, Set& set, std::size_t price) {
  set.octets += price;
  octets_ += price;
  held_[source.identity].open += price;
}

void Presenter::refund_open(const Source& source, Set& set, std::size_t price) {
  set.octets -= price;
  octets_ -= price;
  const auto held = held_.find(source.identity);
  held->second.open -= price;
  forget_empty(held);
}

void Presenter::charge_ready(const Source& source, const Batch& batch) {
  auto& held = held_[source.identity];
  for (const auto& item : batch.items) {
    octets_ += price_of(item);
    held.ready += price_of(item);
  }
}

void Presenter::refund_ready(const Source& source, std::size_t price) {
  octets_ -= price;
  const auto held = held_.find(source.identity);
  held->second.ready -= price;
  forget_empty(held);
}

void Presenter::forget_empty(std::map<GuidPrefix, IdentityOctets>::iterator held) {
  if (held->second.octets() == 0) held_.erase(held);
}

// Complete sets that wait for a reader will be taken, so the change is refused for now. A set that
// grows without end would never be taken, so the largest ones are given up.
bool Presenter::make_room(const Source& source) {
  const auto held = held_.find(source.identity);
  if (held == held_.end()) return octets_ < kMaxOctets;
  if (!is_over(held->second)) return true;
  if (held->second.ready > 0) return false;
  give_up_largest(source.identity);
  return true;
}

// Frees one eighth of the identity's octets at once, so that a large number of small sets is not
// searched for each change.
void Presenter::give_up_largest(const GuidPrefix& identity) {
  struct Open {
    Source* source;
    std::map<SequenceNumber, Set>::iterator set;
  };
  std::vector<Open> open;
  for (auto& [key, source] : sources_) {
    if (source.identity != identity) continue;
    for (auto at = source.sets.begin(); at != source.sets.end(); ++at)
      open.push_back({&source, at});
  }
  std::ranges::sort(open, std::greater{}, [](const Open& o) { return o.set->second.octets; });
  const auto enough = held_[identity].open / 8 * 7;
  for (const auto& [source, set] : open) {
    const auto held = held_.find(identity);
    if (held == held_.end() || held->second.open <= enough) return;
    if (set->second.items.empty()) {
      give_up_set(*source, set);
    } else {
      set->second.is_broken = true;
      lose_items(*source, set->second, PresentedReader::Limit::share);
    }
  }
}

void Presenter::give_up_batch(Batch& batch, const Source& source, PresentedReader::Limit limit) {
  for (const auto& item : batch.items) refund_ready(source, price_of(item));
  for (const auto& [reader, its] : batch.wanted) {
    const bool is_cause = limit != PresentedReader::Limit::samples ||
                          reader->room_for(its.room, its.writer) == Room::never;
    if (is_cause)
      reader->give_up(its.writer, its.room.samples, limit);
    else
      reader->note_lost(its.room.samples);
  }
}

// Later changes of the set do not begin with its first change. The set therefore cannot become
// complete afterwards.
void Presenter::give_up_set(Source& source, std::map<SequenceNumber, Set>::iterator at) {
  for (auto& [key, stream] : source.streams)
    if (stream.set == at->first) stream.set = {};
  remove_set(source, at);
}

// RTPS 8.7.6: a set ends with a change that belongs to another set, to no set, or has no data. A
// set has no gaps in its sequence numbers.
void Presenter::add_to_set(Source& source, const StreamKey& key, Change& change,
                           MonotonicTime now) {
  auto& stream = source.streams[key];
  const auto& in = change.coherence;
  const auto number = change.sequence_number;
  const bool follows = number == stream.last.next();
  stream.progress = std::max(stream.progress, in.group);
  const auto id = !access_.is_coherent                            ? SequenceNumber{}
                  : access_.is_by_group && in.group_set.value > 0 ? in.group_set
                                                                  : in.set;
  const bool ends = change.is_marker() || id.value == 0;
  const auto before = std::exchange(stream.last, number);
  if (stream.set.value > 0 && (ends || id != stream.set))
    end_set(source, key, std::exchange(stream.set, {}), follows ? SetEnd::whole : SetEnd::with_gap,
            now);
  else if (change.is_marker() && id.value > 0)  // the writer wrote nothing in the set
    end_set(source, key, id, follows || before.value == 0 ? SetEnd::whole : SetEnd::with_gap, now);
  if (change.is_marker()) return;
  if (id.value == 0) {
    std::vector<Item> one;
    one.push_back({key.first, std::move(change)});
    return enqueue(
        source, in.group.value > 0 && access_.is_ordered && access_.is_by_group ? in.group : number,
        {std::move(one), in.group, now});
  }
  auto& set = set_of(source, id);
  const bool begins = stream.set.value == 0;
  stream.set = id;
  set.is_broken = set.is_broken || (begins ? number != in.set : !follows);
  add_item(source, set, {key.first, std::move(change)});
}

// Samples of a set that cannot become complete are counted as lost and not kept.
void Presenter::add_item(Source& source, Set& set, Item item) {
  if (set.is_broken) return item.reader->note_lost(1);
  charge_open(source, set, price_of(item));
  set.items.push_back(std::move(item));
}

void Presenter::end_set(Source& source, const StreamKey& key, SequenceNumber id, SetEnd end,
                        MonotonicTime now) {
  auto& set = set_of(source, id);
  set.ended.insert(key);
  set.is_broken = set.is_broken || end == SetEnd::with_gap;
  finish_if_complete(source, id, now);
}

// If there are too many sets, the first is given up. It cannot become complete later, because a
// writer that has ended it does not end it again.
Presenter::Set& Presenter::set_of(Source& source, SequenceNumber id) {
  if (source.sets.size() >= kMaxSets && !source.sets.contains(id))
    give_up_set(source, source.sets.begin());
  const auto [at, is_new] = source.sets.try_emplace(id);
  if (is_new) charge_open(source, at->second, kPricePerItem);
  return at->second;
}

void Presenter::finish_if_complete(Source& source, SequenceNumber id, MonotonicTime now) {
  const auto at = source.sets.find(id);
  if (at == source.sets.end() || at->second.ended.size() < source.streams.size()) return;
  auto& set = at->second;
  if (set.is_broken) lose_items(source, set);
  std::ranges::sort(set.items, {}, [](const Item& item) {
    return std::pair(item.change.coherence.group, item.change.sequence_number);
  });
  if (!set.items.empty()) {
    refund_open(source, set, set.octets - kPricePerItem);
    const auto last = set.items.back().change.coherence.group;
    const auto first = access_.is_by_group ? id : set.items.front().change.sequence_number;
    enqueue(source, first, {std::move(set.items), last.value > 0 ? last.next() : last, now});
  }
  remove_set(source, at);
}

void Presenter::remove_set(Source& source, std::map<SequenceNumber, Set>::iterator at) {
  lose_items(source, at->second);
  refund_open(source, at->second, at->second.octets);
  source.sets.erase(at);
}

void Presenter::lose_items(const Source& source, Set& set,
                           std::optional<PresentedReader::Limit> limit) {
  Batch batch{.items = std::exchange(set.items, {}), .last = {}};
  note_wanted(batch);
  for (const auto& item : batch.items) refund_open(source, set, price_of(item));
  for (const auto& [reader, its] : batch.wanted) {
    if (limit)
      reader->give_up(its.writer, its.room.samples, *limit);
    else
      reader->note_lost(its.room.samples);
  }
}

// The Presenter does not wait for a reader that could never hold the batch: it would present
// nothing after the batch, and no sample of a set may be seen without the others.
void Presenter::enqueue(Source& source, SequenceNumber at, Batch batch) {
  charge_ready(source, batch);
  note_wanted(batch);
  if (room_for(batch) == Room::never)
    return give_up_batch(batch, source, PresentedReader::Limit::samples);
  source.ready.emplace(at, std::move(batch));  // equal keys stay in the order of insertion
}

// True if nothing can arrive any more before the batch (RTPS 8.7.5), or if the wait has ended.
bool Presenter::may_present(const Source& source, SequenceNumber first, const Batch& batch,
                            MonotonicTime now) const {
  if (!access_.is_by_group || batch.last.value == 0) return true;
  if (first <= source.presented.next()) return true;
  const auto passed = [&](const auto& entry) { return entry.second.progress >= first.previous(); };
  return std::ranges::all_of(source.streams, passed) || now >= batch.since + kGapTimeout;
}

void Presenter::note_wanted(Batch& batch) {
  batch.wanted.clear();
  for (const auto& item : batch.items) {
    auto& [room, writer] = batch.wanted[item.reader];
    ++room.samples;
    room.octets += item.change.payload.size();
    // The end of an instance that the reader does not have is not stored.
    if (item.change.is_alive() || item.change.status.disposed)
      room.instances[item.reader->instance_of(item.change)] += item.change.is_alive() ? 1 : 0;
    writer = item.change.writer;
  }
}

Room Presenter::room_for(const Batch& batch) {
  auto out = Room::now;
  for (const auto& [reader, its] : batch.wanted)
    out = std::max(out, reader->room_for(its.room, its.writer));
  return out;
}

// The limits on keys and joins are known only when a change is stored. If one is reached, the rest
// of the batch waits: its writer was told that it has arrived, and would not send it again.
bool Presenter::present_batch(Source& source, Batch& batch) {
  auto next = batch.items.begin();
  for (; next != batch.items.end(); ++next) {
    const auto price = price_of(*next);
    const StreamKey from{next->reader, next->change.writer};
    if (!next->reader->present(next->change)) break;
    refund_ready(source, price);
    note_presented(source, from);
  }
  const bool is_done = next == batch.items.end();
  batch.items.erase(batch.items.begin(), next);
  if (is_done)
    source.presented = std::max(source.presented, batch.last);
  else
    note_wanted(batch);
  return is_done;
}

void Presenter::present_ready_of(Source& source, MonotonicTime now) {
  while (!is_paused_ && !source.ready.empty()) {
    auto& [first, batch] = *source.ready.begin();
    if (!may_present(source, first, batch, now)) return;
    if (batch.is_blocked) return;
    batch.is_blocked = room_for(batch) != Room::now || !present_batch(source, batch);
    if (!batch.is_blocked) {
      source.ready.erase(source.ready.begin());
      continue;
    }
    searched_ = source.key;
    in_vain_ += batch.items.size();
    if (in_vain_ >= kItemsBeforePause)
      search_at_ = now + std::exchange(in_vain_, 0) * kPausePerItem;
    return;
  }
}

void Presenter::unblock(Batch& batch, MonotonicTime now, ReaderRoom room) {
  if (!batch.is_blocked) return;
  batch.retries = batch.retries || room == ReaderRoom::may_be_freed;
  if (!batch.retries) return;
  const bool is_early = now < search_at_;
  retries_ = retries_ || is_early;
  batch.retries = batch.is_blocked = is_early;
}

void Presenter::on_progress(PresentedReader& reader, const Guid& writer, SequenceNumber group,
                            MonotonicTime now) {
  auto* source = find(reader, writer);
  if (source == nullptr) return;
  auto& stream = source->streams[{&reader, writer}];
  stream.progress = std::max(stream.progress, group);
  present_ready_of(*source, now);
}

void Presenter::pause(bool paused, MonotonicTime now) {
  is_paused_ = paused;
  present_ready(now);
}

// Sources take turns: the search begins after the one that was searched last.
void Presenter::present_ready(MonotonicTime now, ReaderRoom room) {
  retries_ = false;
  const auto last = searched_;
  auto at = sources_.upper_bound(last);
  for (const bool from_begin : {false, true}) {
    if (from_begin) at = sources_.begin();
    while (at != sources_.end() && (!from_begin || at->first <= last)) {
      auto& source = at->second;
      if (!source.ready.empty()) unblock(source.ready.begin()->second, now, room);
      present_ready_of(source, now);
      at = forget_if_done(at);
    }
  }
}

MonotonicTime Presenter::next_tick() const {
  if (is_paused_) return kNever;
  auto next = retries_ ? search_at_ : kNever;
  for (const auto& [key, source] : sources_)
    if (!source.ready.empty() && !source.ready.begin()->second.is_blocked)
      next = std::min(next, source.ready.begin()->second.since + kGapTimeout);
  return next;
}

}  // namespace ddssec::rtps
