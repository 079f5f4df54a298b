#include "tests/sim/invariants.hpp"

namespace ddssec::rtps::sim {
namespace {

bool holds_mark(BytesView octets) { return !std::ranges::search(octets, as_bytes(kMark)).empty(); }

}  // namespace

std::string describe(const End& end) {
  return end.subject->name + (end.writes ? "'s writer of " : "'s reader of ") +
         std::string(end.topic);
}

void Invariants::on_sent(const Subject& from, BytesView datagram) {
  if (protection_.hides && from.is_honest() && holds_mark(datagram))
    fail(invariant::kHidden, from.name + " sent a sample in the clear");
}

void Invariants::on_matched(const End& local, const Guid& remote) {
  if (!local.subject->is_honest()) return;
  const auto where = describe(local) + " matched " + remote.to_string();
  const auto* life = ledger_.life(remote.prefix);
  if (life == nullptr) return fail(invariant::kForged, where + " of nobody");
  const auto& peer = *life->subject;
  // Two endpoints of one participant match while they are made, before they have a name here.
  if (&peer == local.subject && life->died == kNever) return;
  if (!peer.may(!local.writes, local.topic) || !local.subject->may(local.writes, local.topic))
    return fail(invariant::kPermission, where + " of " + peer.name);
  if (peer.domain_tag() != local.subject->domain_tag())
    return fail(invariant::kForged, where + " of another domain");
  if (!peer.is_honest()) return;
  const auto end = ends_.find(remote);
  const bool real =
      end != ends_.end() && end->second.topic == local.topic && end->second.writes != local.writes;
  if (!real) fail(invariant::kForged, where + ", which " + peer.name + " never announced so");
}

void Invariants::on_unmatched(const End& local, const Guid& remote) {
  // A durable reader gets the history again in a new session. Above the endpoints, which are not
  // simulated, a DataReader drops what it has (SeenOriginals).
  if (local.durable && !local.writes) latest_.erase({local.guid, remote});
  const auto* own = ledger_.life(local.guid.prefix);
  const auto* life = ledger_.life(remote.prefix);
  const auto lives = [](const Life* one) {
    return one != nullptr && one->died == kNever && one->subject->role == Role::honest;
  };
  if (besieged_ && local.subject->role == Role::honest && lives(own) && lives(life))
    fail(invariant::kKept,
         describe(local) + " lost " + remote.to_string() + " of " + life->subject->name);
}

void Invariants::on_delivered(const End& reader, const Change& change) {
  if (change.writer.prefix == reader.guid.prefix && !reader.subject->is_honest()) return;
  const auto* life = ledger_.life(change.writer.prefix);
  const auto where = describe(reader) + " got a sample of ";
  if (life == nullptr) return fail(invariant::kForged, where + "nobody");
  const auto& peer = *life->subject;
  const bool may_read = reader.subject->may(false, reader.topic);
  if (!may_read && peer.is_honest() && protection_.separates_topics)
    return fail(invariant::kPermission, where + peer.name + " that it may not read");
  if (!reader.subject->is_honest()) return;
  // This is the end of a coherent set. Where headers are not covered, it says no more than a GAP.
  if (change.is_marker() && !protection_.covers_headers) return;
  if (!peer.may(true, reader.topic))
    return fail(invariant::kPermission, where + peer.name + ", who may not write it");
  if (peer.domain_tag() != reader.subject->domain_tag())
    return fail(invariant::kForged, where + "another domain");
  if (peer.is_honest()) check_content(reader, change);
  check_order(reader, change);
}

void Invariants::check_content(const End& reader, const Change& change) {
  const auto name = describe(reader) + ", number " + std::to_string(change.sequence_number.value) +
                    " of " + change.writer.to_string();
  const auto* written = ledger_.written(change.writer, change.sequence_number);
  if (written == nullptr) return fail(invariant::kForged, name + " was never written");
  if (written->topic != reader.topic)
    return fail(invariant::kForged, name + " is of another topic");
  const auto* own = ledger_.life(reader.guid.prefix);
  const auto since = protection_.dates_readers || own == nullptr ? reader.since : own->born;
  if (written->when < since && !reader.durable)
    return fail(invariant::kFresh, name + " is older than the reader");
  if (!std::ranges::equal(written->payload, change.payload.view()))
    return fail(invariant::kForged, name + " has another payload");
  if (written->status != change.status)
    return fail(invariant::kForged, name + " has another status");
  if (protection_.covers_times && written->time != change.source_time)
    fail(invariant::kForged, name + " has another source timestamp");
}

void Invariants::check_order(const End& reader, const Change& change) {
  auto& latest = latest_[{reader.guid, change.writer}];
  if (change.sequence_number <= latest)
    return fail(invariant::kOnce,
                describe(reader) + " got number " + std::to_string(change.sequence_number.value) +
                    " of " + change.writer.to_string() + " after " + std::to_string(latest.value));
  latest = change.sequence_number;
}

void Invariants::on_alive(const End& reader, const Guid& writer) {
  const auto* life = ledger_.life(writer.prefix);
  if (!reader.subject->is_honest() || life == nullptr || life->died == kNever) return;
  const bool all_arrived = besieged_ && life->died >= besieged_since_ && protection_.covers_headers;
  if (now_ - life->died < (all_arrived ? kMaxLastWords : kMaxAfterlife)) return;
  auto& moments = late_signs_[writer];
  moments.insert(now_);
  if (moments.size() > kMaxLateSigns)
    fail(invariant::kLife, describe(reader) + " heard " + writer.to_string());
}

void Invariants::on_handshakes(const Subject& whose, std::size_t begun) {
  most_handshakes_ = std::max(most_handshakes_, begun);
  if (begun > kMaxHandshakes)
    fail(invariant::kWork, whose.name + " began " + std::to_string(begun) + " handshakes at once");
}

void Invariants::on_call(const Subject& whose, const Cost& before, const Cost& after,
                         std::size_t octets) {
  if (!whose.is_honest()) return;
  if (after.octets > max_octets_)
    fail(invariant::kMemory, whose.name + " holds " + std::to_string(after.octets) + " octets");
  const auto branches = after.branches - before.branches;
  const auto of_octets = std::min(branches, kMaxBranchesPerOctet * octets);
  most_branches_ = std::max(most_branches_, branches - of_octets);
  if (branches > kMaxBranches + of_octets)
    fail(invariant::kWork, whose.name + " took " + std::to_string(branches) + " branches for " +
                               std::to_string(octets) + " octets");
}

}  // namespace ddssec::rtps::sim
