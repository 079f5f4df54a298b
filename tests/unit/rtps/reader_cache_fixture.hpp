// A ReaderCache with writers whose changes carry one octet.
#pragma once

#include <gmock/gmock.h>

#include "rtps/dcps/reader_cache.hpp"

namespace ddssec::rtps::testing {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using StoreResult = ReaderCache::StoreResult;
using Reason = SampleRejectedReason;

inline constexpr StatusInfo kDispose{true, false}, kUnregister{false, true}, kBoth{true, true};

inline Guid writer(std::uint8_t n) {
  return {GuidPrefix::from(Bytes(12, n)), EntityId{{0, 0, 1, 2}}};
}

struct Cache : ::testing::Test {
  Qos qos = [] {
    Qos all;
    all.history.kind = HistoryKind::keep_all;
    return all;
  }();
  std::optional<ReaderCache> made;
  MonotonicTime now = std::chrono::seconds(100);

  ReaderCache& cache() {
    if (!made)
      made.emplace(qos, [](const Change& change) { return Bytes{change.key_hash.value()[0]}; });
    return *made;
  }
  Moment moment() const { return {now, Time::from(now)}; }
  /// Stores a change of `key` with the time `at` after the start.
  ReaderCache::StoreReport put(std::uint8_t key, std::uint8_t value, StatusInfo status = {},
                               std::uint8_t from = 1, std::optional<MonotonicTime> stamp = {}) {
    Change change;
    change.writer = writer(from);
    change.key_hash = KeyHash{key};
    change.status = status;
    change.is_key_only = status != StatusInfo{};
    change.source_time = Time::from(stamp.value_or(now));
    change.payload = Payload::copy_of(Bytes{value});
    return cache().store(change, moment());
  }
  std::vector<OctetSample> select(SampleQuery query) {
    std::vector<OctetSample> out;
    cache().select(query, moment(), out);
    return out;
  }
  std::vector<OctetSample> take(States states = {}) {
    return select({.states = states, .take = true});
  }
  std::vector<OctetSample> read(States states = {}) { return select({.states = states}); }
  /// Returns the first octet of each sample: the value, or the key where there is no data.
  static std::vector<int> values(const std::vector<OctetSample>& samples) {
    std::vector<int> out;
    for (const auto& sample : samples) out.push_back(sample.payload.view()[0]);
    return out;
  }
};

}  // namespace ddssec::rtps::testing
