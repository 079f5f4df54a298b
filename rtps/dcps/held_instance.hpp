// An instance that a reader knows, and the samples that it holds of it (DDS 1.4, 2.2.2.5.1).
#pragma once

#include <list>
#include <map>
#include <optional>
#include <vector>

#include "base/clock.hpp"
#include "rtps/dcps/held_shares.hpp"
#include "rtps/dcps/link.hpp"
#include "rtps/dcps/states.hpp"
#include "rtps/reliability/change.hpp"

namespace ddssec::rtps {

/// A sample that a reader holds, or a sample without data that reports the end of its instance.
struct HeldSample {
  Change change;
  bool is_read = false;
  bool valid = true;       ///< has data
  bool by_source = false;  ///< true if its place in its instance depends on its source time
  std::int32_t disposed_generations = 0, no_writers_generations = 0;
  MonotonicTime expires = kNever;
  std::uint64_t expiry = 0;   ///< distinguishes samples that expire at the same time
  std::uint64_t arrival = 0;  ///< position in the order of arrival, if that order is kept
  std::uint64_t place = 0;    ///< distinguishes samples in the order of source times
  HeldShareOf share = {};     ///< that of its writer's identity
  std::int32_t generations() const { return disposed_generations + no_writers_generations; }
};
using HeldSamples = std::list<HeldSample>;

/// A sample's place in the order of source times.
struct SourceOrder {
  std::optional<Time> time;
  Guid writer;
  std::uint64_t place;
  auto operator<=>(const SourceOrder&) const = default;
};

/// Returns a sample's place among those of its instance.
inline SourceOrder place_in_instance(const HeldSample& sample) {
  if (!sample.by_source) return {std::nullopt, {}, sample.place};
  return {sample.change.source_time, sample.change.writer, sample.place};
}

struct HeldInstance;
using InstanceTimes = std::multimap<MonotonicTime, HeldInstance*>;

/// An instance's entry in a table of times. The destructor removes the entry.
class InstanceTime {
 public:
  InstanceTime() = default;
  ~InstanceTime() { leave(); }
  InstanceTime(const InstanceTime&) = delete;
  InstanceTime& operator=(const InstanceTime&) = delete;
  /// `times` must outlive the entry.
  void enter(InstanceTimes& times, MonotonicTime when, HeldInstance& instance);
  void leave();

 private:
  InstanceTimes* in_ = nullptr;
  InstanceTimes::iterator at_;
};

/// An instance in the cache of a reader, with its samples in the order of arrival.
struct HeldInstance {
  InstanceHandle handle;
  KeyHash key{};
  Payload key_value;
  InstanceState state = InstanceState::alive;
  ViewState view = ViewState::new_;
  std::int32_t disposed_generations = 0, no_writers_generations = 0;
  HeldSamples held;
  std::size_t unread = 0;
  HeldSamples::iterator unread_from = held.end();  ///< all before it were read
  std::size_t invalid = 0;                         ///< 0 or 1
  HeldSamples::iterator invalid_at;                ///< only if there is one
  /// With DESTINATION_ORDER BY_SOURCE_TIMESTAMP and a long history: the samples in that order.
  std::map<SourceOrder, HeldSamples::iterator> by_source;
  /// The share of the identity for which the instance and its key count. A writer of this identity
  /// has the instance, as long as any writer has it.
  HeldShareOf share;
  std::size_t payers = 0;          ///< number of this identity's writers in `writers`
  std::vector<Guid> writers;       ///< those that are alive and have not unregistered the instance
  std::optional<Guid> owner;       ///< only with OWNERSHIP EXCLUSIVE
  OriginalWriterInfo latest;       ///< origin of the latest stored change; used as `owner` is
  std::optional<Time> seen_until;  ///< source time of the newest sample that was read or taken
  MonotonicTime deadline = kNever;
  MonotonicTime quiet_until{};      ///< the end of the minimum separation (TIME_BASED_FILTER)
  MonotonicTime release_at{};       ///< not before quiet_until
  std::optional<Change> held_back;  ///< the change that waits until release_at
  HeldShareOf share_of_held_back;
  MonotonicTime expiry_of_held_back = kNever;
  Link<HeldInstance> ready{this};  ///< list of the instances that have samples
  /// List of the instances without samples that are not alive: the first to be removed.
  Link<HeldInstance> idle{this};
  Link<HeldInstance> due{this};    ///< list in the order of deadlines
  Link<HeldInstance> quiet{this};  ///< list in the order of release_at
  InstanceTime purge;              ///< READER_DATA_LIFECYCLE
  std::size_t valid() const { return held.size() - invalid; }
  HeldSamples::const_iterator oldest() const;
  HeldSamples::const_iterator invalid_sample() const { return invalid_at; }
};

}  // namespace ddssec::rtps
