#include "rtps/security/mapped_memory.hpp"

#include <algorithm>

namespace ddssec::rtps {

void MappedMemory::add_reader(const Guid& writer, const EntityId& reader) {
  writers_[writer].readers.insert(reader);
}

void MappedMemory::remove_reader(const Guid& writer, const EntityId& reader) {
  const auto at = writers_.find(writer);
  if (at == writers_.end()) return;
  auto& it = at->second;
  it.readers.erase(reader);
  if (!it.readers.empty()) return;
  forget_former(it);
  requests_ -= it.request ? 1 : 0;
  segments_ -= it.latest ? 1 : 0;
  writers_.erase(at);
}

void MappedMemory::answer(const Guid& writer, std::uint64_t segment,
                          std::optional<memory::Refusal> refusal) {
  answer_(writer.prefix, {writer.entity, segment, refusal});
}

void MappedMemory::on_offer(const GuidPrefix& from, const MemoryOffer& offer, MonotonicTime now) {
  const Guid writer{from, offer.writer};
  const auto at = writers_.find(writer);
  if (at == writers_.end())
    return answer(writer, offer.offer.segment, memory::Refusal::not_matched);
  auto& it = at->second;
  if (!it.offers.take(now)) return;
  requests_ -= it.request ? 1 : 0;
  it.request.reset();
  if (!has_room(from)) return answer(writer, offer.offer.segment, memory::Refusal::no_memory);
  auto request = requested(offer, now);
  if (!request) return answer(writer, offer.offer.segment, request.error());
  it.request.emplace(*std::move(request));
  ++requests_;
}

bool MappedMemory::has_room(const GuidPrefix& from) const {
  if (segments_ + requests_ >= kMostSegments) return false;
  std::size_t of_one = 0;
  for (auto at = writers_.lower_bound({from, {}}); at != writers_.end(); ++at) {
    const auto& [writer, it] = *at;
    if (writer.prefix != from) break;
    of_one += (it.request ? 1u : 0u) + (it.latest ? 1u : 0u) + (it.former ? 1u : 0u);
  }
  return of_one < kMostOfOne;
}

memory::Outcome<MappedMemory::Request> MappedMemory::requested(const MemoryOffer& offer,
                                                               MonotonicTime now) {
  auto sent = memory::DescriptorRequest::send(offer.offer);
  if (!sent) return memory::refuse(sent.error());
  if (!readiness_.add(sent->descriptor())) return memory::refuse(memory::Refusal::no_socket);
  return Request{offer.offer.segment, *std::move(sent), now + kLongestRequest};
}

void MappedMemory::serve(MonotonicTime now) {
  if (requests_ + formers_ == 0) return;
  for (auto& [writer, it] : writers_) {
    if (it.former && now >= it.former_until) forget_former(it);
    if (it.request && take(writer, it, now)) {
      it.request.reset();
      --requests_;
    }
  }
}

bool MappedMemory::take(const Guid& writer, OfWriter& it, MonotonicTime now) {
  auto& request = *it.request;
  auto taken = request.request.take();
  const bool waits = taken && !*taken;
  if (waits && now < request.until) return false;
  if (waits || !taken) {
    answer(writer, request.segment, waits ? memory::Refusal::no_answer : taken.error());
    return true;
  }
  keep(it, {request.segment, **std::move(taken)}, now);
  answer(writer, request.segment, std::nullopt);
  return true;
}

void MappedMemory::keep(OfWriter& it, Segment segment, MonotonicTime now) {
  forget_former(it);
  if (it.latest) {
    it.former = std::move(it.latest);
    it.former_until = now + kFormer;
    ++formers_;
  }
  it.latest.emplace(std::move(segment));
  ++segments_;
}

void MappedMemory::forget_former(OfWriter& it) {
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
  if (at == writers_.end() || reference.length == 0 || reference.length > kLargestPayload)
    return {};
  auto& it = at->second;
  for (const auto* segment : {&it.latest, &it.former}) {
    if (!*segment || (*segment)->id != reference.segment) continue;
    const auto& mapped = (*segment)->mapped;
    if (!mapped.check(reference)) return {};
    auto out = Payload::uninitialized(reference.length);
    return mapped.copy(reference, out.fill()) ? out : Payload();
  }
  const bool is_awaited = it.request && it.request->segment == reference.segment;
  if (!is_awaited && it.complaints.take(now))
    answer(writer, reference.segment, memory::Refusal::other_segment);
  return {};
}

}  // namespace ddssec::rtps
