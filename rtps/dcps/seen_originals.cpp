#include "rtps/dcps/seen_originals.hpp"

#include <algorithm>
#include <array>

#include "base/writer.hpp"

namespace ddssec::rtps {
namespace {

// The largest difference between the expiry times of two copies of a sample that arrive one after
// the other.
constexpr std::chrono::milliseconds kSameTime{10};

bool is_claim(const Change& change) {
  return change.original.number.value > 0 && change.original.writer != change.writer;
}

// The digest covers everything that a reader sees. A dispose with an unregistration has the digest
// of a dispose, because a durability service that keeps a dispose does not keep the unregistration
// with it.
Sha256Digest digest_of(const Change& change, BytesView padding = {}) {
  const auto& status = change.status;
  const auto key = change.key_hash.value_or(KeyHash{});
  const auto time = change.source_time.value_or(kTimeInvalid);
  Writer head;
  head.write(static_cast<std::uint8_t>(status.disposed       ? 2
                                       : status.unregistered ? 1
                                       : change.is_key_only  ? 3
                                                             : 0));
  head.write(std::uint8_t{change.key_hash.has_value()});
  head.write_bytes(key);
  head.write(time.seconds);
  head.write(time.fraction);
  return sha256({head.view(), change.payload.view(), padding});
}

// True if the change is the sample of the claim. That sample may have received up to three octets
// of submessage padding on its way.
bool says(const Change& change, const Sha256Digest& claim) {
  constexpr std::array<std::uint8_t, 3> kZeros{};
  const auto missing = (4 - change.payload.size() % 4) % 4;
  return digest_of(change) == claim ||
         (missing != 0 && digest_of(change, BytesView(kZeros).first(missing)) == claim);
}

}  // namespace

SeenOriginals::Sighting SeenOriginals::of(const Change& change, MonotonicTime expires) {
  Sighting out{change.origin(), std::nullopt, expires};
  if (is_claim(change)) out.claim = digest_of(change);
  return out;
}

bool SeenOriginals::contains(const Change& change, MonotonicTime expires) const {
  const auto origin = change.origin();
  if (heard(origin)) return true;
  if (claims_.empty()) return false;
  const auto claim = claims_.find({origin.writer, origin.number});
  if (claim == claims_.end() || expires - kSameTime > claim->second.expires) return false;
  return says(change, claim->second.digest);
}

void SeenOriginals::add(const Sighting& sighting) {
  if (sighting.claim)
    note_claim(sighting.origin, {*sighting.claim, sighting.expires});
  else
    hear(sighting.origin);
}

void SeenOriginals::note_claim(const OriginalWriterInfo& original, const Claim& claim) {
  const std::pair key(original.writer, original.number);
  const auto [at, is_new] = claims_.insert_or_assign(key, claim);
  if (!is_new) return;
  order_.push_back(key);
  if (order_.size() <= kMaxClaims) return;
  claims_.erase(order_.front());
  order_.pop_front();
}

bool SeenOriginals::heard(const OriginalWriterInfo& original) const {
  const auto at = writers_.find(original.writer);
  if (at == writers_.end()) return false;
  const auto number = original.number.value;
  const auto& ranges = at->second.ranges;
  const auto range = std::ranges::lower_bound(ranges, number, {}, &Range::last);
  return range != ranges.end() && range->first <= number;
}

void SeenOriginals::hear(const OriginalWriterInfo& original) {
  if (writers_.size() >= kMaxWriters && !writers_.contains(original.writer)) forget_oldest();
  auto& [ranges, used] = writers_[original.writer];
  used = ++uses_;
  const auto number = original.number.value;
  const auto after = std::ranges::lower_bound(ranges, number, {}, &Range::last);
  if (after != ranges.end() && after->first <= number) return;
  const bool joins_after = after != ranges.end() && after->first == number + 1;
  if (after != ranges.begin() && std::prev(after)->last == number - 1) {
    std::prev(after)->last = joins_after ? after->last : number;
    if (joins_after) ranges.erase(after), --ranges_;
  } else if (joins_after) {
    after->first = number;
  } else {
    ranges.insert(after, {number, number});
    if (++ranges_ > kMaxRanges) forget_oldest_ranges();
  }
}

void SeenOriginals::forget_oldest() {
  const auto oldest =
      std::ranges::min_element(writers_, {}, [](const auto& entry) { return entry.second.used; });
  ranges_ -= oldest->second.ranges.size();
  writers_.erase(oldest);
}

// Several ranges are forgotten at once, because the search looks at all writers.
void SeenOriginals::forget_oldest_ranges() {
  auto& most = std::ranges::max_element(writers_, {}, [](const auto& entry) {
                 return entry.second.ranges.size();
               })->second.ranges;
  const auto count = static_cast<std::ptrdiff_t>(most.size() / 64 + 1);
  most.erase(most.begin(), most.begin() + count);
  ranges_ -= static_cast<std::size_t>(count);
}

}  // namespace ddssec::rtps
