#include "rtps/reliability/writer_messages.hpp"

#include <algorithm>

#include "rtps/reliability/end_mark.hpp"
#include "wire/data_frag.hpp"

namespace ddssec::rtps {
namespace {

PayloadKind kind_of(const Change& change) {
  if (change.payload.size() == 0) return PayloadKind::none;
  return change.is_key_only ? PayloadKind::key : PayloadKind::data;
}

}  // namespace

// The payload of an alive sample contains its key. A dispose needs the key hash, because Fast DDS
// ignores a dispose without it. So does a sample for a durability service, which stores samples
// without knowing their type.
InlineQos WriterMessages::inline_qos_of(const Change& change,
                                        std::span<const FilterResult> filters) const {
  const auto time = sender_.leaves_time_unprotected(writer_) ? change.source_time : std::nullopt;
  if (!change.is_alive())
    return {change.key_hash, change.status, change.coherence, change.original, time, {}, {}};
  const bool is_kept = durability_ >= DurabilityKind::transient;
  return {is_kept ? change.key_hash : std::nullopt,
          {},
          change.coherence,
          change.original,
          time,
          {filters},
          {}};
}

BytesView WriterMessages::payload_of(const Change& change) {
  const auto octets = change.payload.view();
  if (is_builtin(writer_) || !change.is_key_only) return octets;
  return key_payload_for(key_reading_, octets, to_bare_key_, key_scratch_);
}

BytesView WriterMessages::marked(const Change& change, BytesView beginning) {
  const auto mark = end_mark(change.status, change.is_key_only);
  if (beginning.empty() || has_end_mark(beginning, mark) || !sender_.protects_payload(writer_))
    return beginning;
  if (beginning.data() != key_scratch_.data())
    key_scratch_.assign(beginning.begin(), beginning.end());
  const auto out = MutableBytes(key_scratch_).first(beginning.size());
  set_end_mark(out, mark);
  return out;
}

void WriterMessages::change(const Receiver& receiver, const Change& change,
                            std::span<const FilterResult> filters, std::uint32_t max_fragments) {
  const auto payload = payload_of(change);
  if (payload.size() > sender_.fragment_size()) {
    const auto total =
        DataFrag::fragments_of(static_cast<std::uint32_t>(payload.size()), sender_.fragment_size());
    const auto count =
        std::min<std::size_t>({total, max_fragments, sender_.fragments_left(receiver.to)});
    for (std::uint32_t number = 1; number <= count; ++number)
      fragment(receiver, change, {number}, filters);
    return;
  }
  const Data data{receiver.reader,        writer_,
                  change.sequence_number, inline_qos_of(change, filters),
                  kind_of(change),        marked(change, payload)};
  sender_.add(receiver.to, InfoTimestamp{change.source_time}, data);
}

void WriterMessages::reference(const Receiver& receiver, const Change& change,
                               const MemoryReference& memory,
                               std::span<const FilterResult> filters) {
  Data data{receiver.reader,   writer_, change.sequence_number, inline_qos_of(change, filters),
            PayloadKind::none, {}};
  data.inline_qos.memory = memory;
  sender_.add(receiver.to, InfoTimestamp{change.source_time}, data);
}

void WriterMessages::fragment(const Receiver& receiver, const Change& change, FragmentNumber number,
                              std::span<const FilterResult> filters) {
  const auto octets = payload_of(change);
  const auto begin = std::size_t{number.value - 1} * sender_.fragment_size();
  if (begin >= octets.size()) return;
  const auto size = std::min<std::size_t>(sender_.fragment_size(), octets.size() - begin);
  const auto part = octets.subspan(begin, size);
  const DataFrag frag{receiver.reader,
                      writer_,
                      change.sequence_number,
                      number,
                      1,
                      sender_.fragment_size(),
                      static_cast<std::uint32_t>(octets.size()),
                      inline_qos_of(change, filters),
                      change.is_key_only,
                      begin == 0 ? marked(change, part) : part};
  sender_.add(receiver.to, InfoTimestamp{change.source_time}, frag);
}

void WriterMessages::gap(const Receiver& receiver, SequenceNumber first, SequenceNumber end) {
  Gap gap{receiver.reader, writer_, first, SequenceNumberSet(end), {}};
  if (group_ != nullptr) {
    const auto* before = history_.find(first.previous());
    const auto* after = history_.find(end);
    const auto from = before != nullptr ? before->coherence.group.next() : SequenceNumber{1};
    const auto to = after != nullptr ? after->coherence.group.previous() : group_->current;
    if (from.value >= 1 && to >= from.previous()) gap.group = {from, to};
  }
  sender_.add(receiver.to, gap);
}

void WriterMessages::heartbeat(const Receiver& receiver, SequenceNumber first,
                               HeartbeatFlags flags) {
  sender_.add(receiver.to,
              Heartbeat{receiver.reader, writer_, first, history_.last(), ++heartbeat_count_,
                        flags.is_final, flags.asserts_liveliness, group_state()});
}

// If no change is held, the range is empty and begins after everything that was written.
std::optional<HeartbeatGroupInfo> WriterMessages::group_state() const {
  if (group_ == nullptr) return std::nullopt;
  HeartbeatGroupInfo out{
      group_->current, group_->current.next(), group_->current, group_->writers, {}};
  const auto* first = history_.find(history_.first());
  const auto* last = history_.find(history_.last());
  if (first != nullptr && last != nullptr && first->coherence.group.value > 0) {
    out.first = first->coherence.group;
    out.last = std::max(last->coherence.group, out.first.previous());
  }
  return out;
}

}  // namespace ddssec::rtps
