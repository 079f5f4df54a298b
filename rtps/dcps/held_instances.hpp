// The instances that a reader knows, with their samples and states (DDS 1.4, 2.2.2.5.1), within
// RESOURCE_LIMITS. Which change may enter and when it ends is ReaderCache's business. No I/O, clock
// or lock.
#pragma once

#include <array>
#include <list>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "rtps/dcps/link.hpp"
#include "rtps/dcps/status.hpp"
#include "rtps/qos/qos.hpp"
#include "rtps/reliability/stateful_writer.hpp"

namespace ddssec::rtps {

/// A sample that a reader holds, or the news that its instance has ended.
struct HeldSample {
  Change change;
  bool is_read = false;
  bool valid = true;  ///< has data
  std::int32_t disposed_generations = 0, no_writers_generations = 0;
  MonotonicTime expires = kNever;
  std::uint64_t expiry = 0;   ///< tells it from others that expire at the same moment
  std::uint64_t arrival = 0;  ///< if ordered
  std::int32_t generations() const { return disposed_generations + no_writers_generations; }
};
using HeldSamples = std::list<HeldSample>;

struct HeldInstance;
using InstanceTimes = std::multimap<MonotonicTime, HeldInstance*>;

/// An instance's place in a table of times, which it leaves when it ends.
class InstanceTime {
 public:
  InstanceTime() = default;
  ~InstanceTime() { leave(); }
  InstanceTime(const InstanceTime&) = delete;
  InstanceTime& operator=(const InstanceTime&) = delete;
  /// `times` outlives the place.
  void enter(InstanceTimes& times, MonotonicTime when, HeldInstance& instance);
  void leave();

 private:
  InstanceTimes* in_ = nullptr;
  InstanceTimes::iterator at_;
};

struct HeldInstance {
  InstanceHandle handle;
  KeyHash key{};
  Payload key_value;
  InstanceState state = InstanceState::alive;
  ViewState view = ViewState::new_;
  std::int32_t disposed_generations = 0, no_writers_generations = 0;
  HeldSamples held;
  std::size_t unread = 0, invalid = 0;
  std::optional<GuidPrefix> identity;  ///< whose sample was the first: see ReaderCache::set_writer
  std::vector<Guid> writers;           ///< alive, and have not unregistered it
  std::optional<Guid> owner;           ///< EXCLUSIVE only
  std::optional<Time> seen_until;      ///< source time of the newest sample that was handed out
  MonotonicTime deadline = kNever;
  MonotonicTime quiet_until{};      ///< TIME_BASED_FILTER
  std::optional<Change> held_back;  ///< until then
  Link<HeldInstance> ready{this};   ///< has samples
  Link<HeldInstance> idle{this};    ///< has none and is not alive: the first to go
  Link<HeldInstance> due{this};     ///< in the order of deadlines
  Link<HeldInstance> quiet{this};   ///< in the order of quiet_until
  InstanceTime purge;               ///< READER_DATA_LIFECYCLE
  std::size_t valid() const { return held.size() - invalid; }
  HeldSamples::const_iterator oldest() const;
  HeldSamples::const_iterator invalid_sample() const;
};

/// For samples that are to be stored together.
enum class Room : std::uint8_t {
  now,
  later,  ///< when the reader has taken others
  never,  ///< not even if it held no others
};

class HeldInstances {
 public:
  /// Where RESOURCE_LIMITS says "unlimited", memory is still bounded.
  static constexpr std::size_t kMaxSamples = 65536;
  /// The same, and no identity has the first sample of more instances than are free: there is
  /// always room for another one.
  static constexpr std::size_t kMaxInstances = 131072;
  static constexpr std::size_t kMaxOctets = std::size_t{256} << 20;

  explicit HeldInstances(const Qos& qos);

  /// nullptr: not known.
  HeldInstance* find(const KeyHash& key) const;
  HeldInstance* find(InstanceHandle handle);
  const std::map<InstanceHandle, HeldInstance>& all() const { return instances_; }
  std::map<InstanceHandle, HeldInstance>& all() { return instances_; }
  /// Those with samples. An instance may leave while the list is walked.
  const LinkedList<HeldInstance>& ready() const { return ready_; }

  /// Why the change has no room. `instance`: the one that it is of; nullptr: a new one of
  /// `identity`.
  SampleRejectedReason rejects(const HeldInstance* instance, const Change& change,
                               const std::optional<GuidPrefix>& identity = {}) const;
  /// KEEP_LAST: the next sample replaces the oldest.
  bool is_full(const HeldInstance& instance) const;
  /// Whether so many more samples can be stored, of whatever instance.
  Room room_for(std::size_t samples, std::size_t octets) const;
  /// Only if `rejects` found room, which the oldest idle instance may have to make.
  HeldInstance& create(const KeyHash& key, Payload key_value,
                       const std::optional<GuidPrefix>& identity = {});
  /// To be called after a change to the instance: it goes where it belongs, or is forgotten.
  void settle(HeldInstance& instance);
  /// It must have no samples.
  void forget(HeldInstance& instance);

  void insert(HeldInstance& instance, HeldSample held);
  /// Says that the instance has ended; one sample says it for the instance, and says the latest.
  void insert_invalid(HeldInstance& instance, const Guid& writer, const std::optional<Time>& time);
  HeldSamples::iterator erase(HeldInstance& instance, HeldSamples::const_iterator at);
  struct Expiring {
    HeldInstance* instance;
    HeldSamples::const_iterator sample;
  };
  /// The first whose time is over.
  std::optional<Expiring> expired(MonotonicTime now) const;
  /// kNever: none expires.
  MonotonicTime next_expiry() const;
  void erase_all(HeldInstance& instance);
  /// Keeps a change for later in place of the one that is kept, if there is room for it.
  void hold_back(HeldInstance& instance, std::optional<Change> change);
  std::optional<Change> take_held_back(HeldInstance& instance);

  void join(HeldInstance& instance, const Guid& writer);
  /// False: it was none of the instance's writers.
  bool leave(HeldInstance& instance, const Guid& writer);
  /// The instances that the writer has joined.
  std::vector<InstanceHandle> joined_by(const Guid& writer) const;

  /// Samples are numbered as they come in; `arrivals` counts them, also those of other readers.
  void order_by_arrival(std::uint64_t& arrivals) { arrivals_ = &arrivals; }
  bool is_ordered() const { return arrivals_ != nullptr; }
  /// True if any sample is in these states.
  bool any(const States& states) const;
  std::size_t samples() const { return samples_; }
  std::size_t max_samples() const { return max_samples_; }
  std::size_t octets() const { return octets_; }

  /// Keeps the counts by state right over whatever happens to an instance while it lives.
  class Recount {
   public:
    Recount(HeldInstances& all, HeldInstance& instance) : all_(all), instance_(instance) {
      all_.count(instance_, -1);
    }
    ~Recount() { all_.count(instance_, 1); }
    Recount(const Recount&) = delete;
    Recount& operator=(const Recount&) = delete;

   private:
    HeldInstances& all_;
    HeldInstance& instance_;
  };

 private:
  void count(const HeldInstance& instance, int sign);
  bool has_room_for_instance(const std::optional<GuidPrefix>& identity) const;

  const History history_;
  const std::size_t max_samples_, max_instances_, max_per_instance_;
  const bool by_source_, shares_;
  std::uint64_t* arrivals_ = nullptr;
  LinkedList<HeldInstance> ready_, idle_;  ///< outlive the instances that are in them
  std::map<InstanceHandle, HeldInstance> instances_;
  std::map<KeyHash, HeldInstance*> by_key_;
  std::map<GuidPrefix, std::size_t> of_identity_;  ///< instances; only if they are shared
  /// Which writer is among those of which instance, so that one that goes costs only its own.
  std::set<std::pair<Guid, InstanceHandle>> joined_;
  std::map<std::pair<MonotonicTime, std::uint64_t>, Expiring> expiring_;
  std::uint64_t expiries_ = 0;
  HeldSamples spare_;  ///< nodes of the past: a sample that comes allocates none
  std::size_t samples_ = 0, octets_ = 0;
  std::array<std::size_t, 12> counts_{};  ///< of samples, by their three states
  std::uint64_t next_handle_ = 1;
};

}  // namespace ddssec::rtps
