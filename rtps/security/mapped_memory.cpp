#include "rtps/security/mapped_memory.hpp"

#include <algorithm>

namespace ddssec::rtps {

void MappedMemory::add_reader(const Guid& writer, const EntityId& reader, bool is_here) {
  const auto [at, is_new] = writers_.try_emplace(writer);
  at->second.readers.insert(reader);
  if (is_new) at->second.expects_offer = is_here;
}

// A writer offers its memory when it writes the first large sample. If large samples arrive in
// messages for too long, the missing offer is reported.
void MappedMemory::note_message(const Guid& writer, std::size_t octets, MonotonicTime now) {
  if (octets < kMinLarge) return;
  const auto at = writers_.find(writer);
  if (at == writers_.end() || !at->second.expects_offer) return;
  auto& it = at->second;
  if (!it.large_since) it.large_since = now;
  if (now < *it.large_since + kMaxWait) return;
  it.expects_offer = false;
  if (not_offered_) not_offered_(writer.prefix);
}

void MappedMemory::remove_reader(const Guid& writer, const EntityId& reader) {
  const auto at = writers_.find(writer);
  if (at == writers_.end()) return;
  auto& it = at->second;
  it.readers.erase(reader);
  if (!it.readers.empty()) return;
  forget_former(it);
  abandon_request(writer.prefix, it);
  segments_ -= it.latest ? 1 : 0;
  writers_.erase(at);
  const auto next = writers_.lower_bound({writer.prefix, {}});
  if (next == writers_.end() || next->first.prefix != writer.prefix) copies_.erase(writer.prefix);
}

void MappedMemory::answer(const Guid& writer, std::uint64_t segment,
                          std::optional<memory::MemoryRefusal> refusal) {
  answer_(writer.prefix, {writer.entity, segment, refusal});
}

void MappedMemory::on_offer(const GuidPrefix& from, MemoryOffer offer, MonotonicTime now) {
  const Guid writer{from, offer.writer};
  const auto segment = offer.offer.segment;
  const auto at = writers_.find(writer);
  if (at == writers_.end()) return answer(writer, segment, memory::MemoryRefusal::not_matched);
  auto& it = at->second;
  it.expects_offer = false;
  if (!it.offers.try_spend(now)) return;
  abandon_request(from, it);
  if (!has_room(from)) return answer(writer, segment, memory::MemoryRefusal::no_memory);
  const auto id = passing_.fetch(std::move(offer.offer));
  if (!id) return answer(writer, segment, id.error());
  it.request = {segment, *id, now + kMaxRequest};
  ++requests_;
}

bool MappedMemory::has_room(const GuidPrefix& from) const {
  if (segments_ + requests_ >= kMaxSegments) return false;
  std::size_t of_one = 0;
  auto requests_of_one = static_cast<std::size_t>(
      std::ranges::count(abandoned_, from, [](const auto& entry) { return entry.second; }));
  for (auto at = writers_.lower_bound({from, {}}); at != writers_.end(); ++at) {
    const auto& [writer, it] = *at;
    if (writer.prefix != from) break;
    requests_of_one += it.request ? 1u : 0u;
    of_one += (it.request ? 1u : 0u) + (it.latest ? 1u : 0u) + (it.former ? 1u : 0u);
  }
  return of_one < kMaxOfOne && requests_of_one < kMaxRequestsOfOne;
}

bool MappedMemory::has_octets_for(const GuidPrefix& from, std::size_t more) const {
  std::size_t all = more, of_one = more;
  for (const auto& [writer, it] : writers_)
    for (const auto* segment : {&it.latest, &it.former}) {
      const auto octets = *segment ? (*segment)->mapped.octets() : 0;
      all += octets;
      of_one += writer.prefix == from ? octets : 0;
    }
  return all <= kMaxOctets && of_one <= kMaxOctetsOfOne;
}

std::shared_ptr<MappedMemory::Copies> MappedMemory::copies_for(const GuidPrefix& from,
                                                               MonotonicTime now) {
  if (!identity_of_) return std::make_shared<Copies>(kCopiedAtOnce, now);
  std::erase_if(of_identities_, [](const auto& entry) { return entry.second.expired(); });
  auto& known = of_identities_[identity_of_(from)];
  auto out = known.lock();
  if (!out) known = out = std::make_shared<Copies>(kCopiedAtOnce, now);
  return out;
}

// A sample beyond this limit counts as not arrived. A reliable reader then gets it in a message.
bool MappedMemory::may_copy(const GuidPrefix& from, std::size_t octets, MonotonicTime now) {
  auto& shared = copies_[from];
  if (!shared) shared = copies_for(from, now);
  auto& copies = *shared;
  using Seconds = std::chrono::duration<double>;
  const auto passed = std::min<double>(Seconds(now - copies.since).count(), 1);
  copies.left = std::min(
      kCopiedAtOnce,
      copies.left + static_cast<std::int64_t>(passed * static_cast<double>(kCopiedInASecond)));
  copies.since = now;
  const auto wanted = static_cast<std::int64_t>(octets);
  if (wanted > copies.left) return false;
  copies.left -= wanted;
  return true;
}

void MappedMemory::end_request(WriterMemory& it) {
  requests_ -= it.request ? 1 : 0;
  it.request.reset();
}

// DescriptorPassing goes on with the request, and has room for few. So the request counts until its
// result is there.
void MappedMemory::abandon_request(const GuidPrefix& from, WriterMemory& it) {
  if (it.request) abandoned_.emplace(it.request->id, from);
  end_request(it);
}

void MappedMemory::serve(MonotonicTime now) {
  for (auto& fetched : passing_.take_fetched()) on_fetched(std::move(fetched), now);
  if (requests_ + formers_ == 0) return;
  for (auto& [writer, it] : writers_) {
    if (it.former && now >= it.former_until) forget_former(it);
    if (!it.request || now < it.request->until) continue;
    answer(writer, it.request->segment, memory::MemoryRefusal::no_answer);
    abandon_request(writer.prefix, it);
  }
}

// A segment for which no request waits any longer is unmapped.
void MappedMemory::on_fetched(memory::DescriptorPassing::FetchedSegment fetched,
                              MonotonicTime now) {
  if (abandoned_.erase(fetched.id) > 0) return;
  const auto at = std::ranges::find_if(writers_, [&](const auto& entry) {
    const auto& request = entry.second.request;
    return request && request->id == fetched.id;
  });
  if (at == writers_.end()) return;
  auto& [writer, it] = *at;
  const auto segment = it.request->segment;
  end_request(it);
  if (!fetched.segment) return answer(writer, segment, fetched.segment.error());
  if (!has_octets_for(writer.prefix, fetched.segment->octets()))
    return answer(writer, segment, memory::MemoryRefusal::no_memory);
  keep(it, {segment, *std::move(fetched.segment)}, now);
  answer(writer, segment, std::nullopt);
}

void MappedMemory::keep(WriterMemory& it, Segment segment, MonotonicTime now) {
  forget_former(it);
  if (it.latest) {
    it.former = std::move(it.latest);
    it.former_until = now + kFormer;
    ++formers_;
  }
  it.latest.emplace(std::move(segment));
  ++segments_;
}

void MappedMemory::forget_former(WriterMemory& it) {
  if (!it.former) return;
  it.former.reset();
  --formers_;
  --segments_;
}

MonotonicTime MappedMemory::next_tick() const {
  auto next = kNever;
  if (requests_ + formers_ > 0)
    for (const auto& [writer, it] : writers_) {
      if (it.request) next = std::min(next, it.request->until);
      if (it.former) next = std::min(next, it.former_until);
    }
  return next;
}

Payload MappedMemory::fetch(const Guid& writer, const MemoryReference& reference,
                            MonotonicTime now) {
  const auto at = writers_.find(writer);
  if (at == writers_.end() || reference.length == 0 || reference.length > kMaxPayload) return {};
  auto& it = at->second;
  for (const auto* segment : {&it.latest, &it.former}) {
    if (!*segment || (*segment)->id != reference.segment) continue;
    const auto& mapped = (*segment)->mapped;
    if (!mapped.check(reference) || !may_copy(writer.prefix, reference.length, now)) return {};
    auto out = Payload::uninitialized(reference.length);
    return mapped.copy(reference, out.fill()) ? out : Payload();
  }
  const bool is_awaited = it.request && it.request->segment == reference.segment;
  if (!is_awaited && it.complaints.try_spend(now))
    answer(writer, reference.segment, memory::MemoryRefusal::other_segment);
  return {};
}

}  // namespace ddssec::rtps
