// The instances that a reader knows, with their samples and states (DDS 1.4, 2.2.2.5.1), within
// RESOURCE_LIMITS. ReaderCache decides which changes are stored and when they end. No I/O, clock or
// lock.
#pragma once

#include <array>
#include <list>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "rtps/dcps/instance_writers.hpp"
#include "rtps/dcps/link.hpp"
#include "rtps/qos/qos.hpp"
#include "rtps/reliability/stateful_writer.hpp"

namespace ddssec::rtps {

/// A sample that a reader holds, or a sample without data that reports the end of its instance.
struct HeldSample {
  Change change;
  bool is_read = false;
  bool valid = true;  ///< has data
  std::int32_t disposed_generations = 0, no_writers_generations = 0;
  MonotonicTime expires = kNever;
  std::uint64_t expiry = 0;   ///< distinguishes samples that expire at the same time
  std::uint64_t arrival = 0;  ///< position in the order of arrival, if that order is kept
  std::uint64_t place = 0;    ///< distinguishes samples in the order of source times
  HeldShareOf share = {};     ///< of its writer's identity
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

struct HeldInstance {
  InstanceHandle handle;
  KeyHash key{};
  Payload key_value;
  InstanceState state = InstanceState::alive;
  ViewState view = ViewState::new_;
  std::int32_t disposed_generations = 0, no_writers_generations = 0;
  HeldSamples held;
  std::size_t unread = 0;
  std::size_t invalid = 0;           ///< 0 or 1
  HeldSamples::iterator invalid_at;  ///< only if there is one
  /// With DESTINATION_ORDER BY_SOURCE_TIMESTAMP and a long history: the samples in that order.
  std::map<SourceOrder, HeldSamples::iterator> by_source;
  /// Of the first sample's writer; see ReaderCache::set_writer.
  std::optional<GuidPrefix> identity;
  HeldShareOf share;               ///< the same; its key counts for it
  std::vector<Guid> writers;       ///< those that are alive and have not unregistered the instance
  std::optional<Guid> owner;       ///< only with OWNERSHIP EXCLUSIVE
  Original latest;                 ///< the origin of the latest stored change; the same
  std::optional<Time> seen_until;  ///< source time of the newest sample that was read or taken
  MonotonicTime deadline = kNever;
  MonotonicTime quiet_until{};      ///< TIME_BASED_FILTER
  MonotonicTime release_at{};       ///< not before quiet_until
  std::optional<Change> held_back;  ///< kept until release_at
  HeldShareOf share_of_held_back;
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

/// Whether samples that belong together can be stored.
enum class Room : std::uint8_t {
  now,
  later,  ///< when samples that the reader holds have been taken
  never,  ///< not even if the reader held no other samples
};

class HeldInstances {
 public:
  /// The limits where RESOURCE_LIMITS says "unlimited", so that memory stays bounded. No identity
  /// may have more samples than are still free, nor the first sample of more instances than are
  /// still free. So there is always room for another identity.
  static constexpr std::size_t kMaxSamples = 131072;
  static constexpr std::size_t kMaxInstances = 131072;
  /// Limit for the octets of samples and keys, with the same rule.
  static constexpr std::size_t kMaxOctets = std::size_t{256} << 20;

  explicit HeldInstances(const Qos& qos);

  /// Returns nullptr if the instance is not known.
  HeldInstance* find(const KeyHash& key) const;
  HeldInstance* find(InstanceHandle handle);
  const std::map<InstanceHandle, HeldInstance>& all() const { return instances_; }
  std::map<InstanceHandle, HeldInstance>& all() { return instances_; }
  /// The instances with samples. An instance may be removed while the list is iterated.
  const LinkedList<HeldInstance>& ready() const { return ready_; }

  /// Whose shares a change uses.
  struct Payer {
    const std::optional<GuidPrefix>& identity;
    const HeldShareOf& share;
  };
  struct Rejection {
    SampleRejectedReason reason = SampleRejectedReason::not_rejected;
    bool crowded = false;  ///< due to a limit that identities share
  };
  /// Returns the limit that leaves no room for the change, or not_rejected. `instance`: the
  /// instance of the change; nullptr: a new one with a key of so many octets.
  Rejection rejects(const HeldInstance* instance, const Change& change, const Payer& payer,
                    std::size_t key_octets) const;
  /// With KEEP_LAST: the next sample replaces the oldest one.
  bool is_full(const HeldInstance& instance) const;
  /// Whether this many more samples of an identity can be stored, of any instances.
  Room room_for(std::size_t samples, std::size_t octets, const HeldShareOf& share) const;
  /// Must be called only if `rejects` found room. May remove the oldest idle instance to make room.
  HeldInstance& create(const KeyHash& key, Payload key_value, const Payer& payer);
  /// Must be called after a change to the instance. Moves it to the lists where it belongs, or
  /// forgets it.
  void settle(HeldInstance& instance);
  /// The instance must not have samples.
  void forget(HeldInstance& instance);

  void insert(HeldInstance& instance, HeldSample held);
  /// Inserts a sample without data that reports the end of the instance. There is at most one for
  /// each instance, and it reports the latest state.
  void insert_invalid(HeldInstance& instance, const Guid& writer, const std::optional<Time>& time);
  HeldSamples::iterator erase(HeldInstance& instance, HeldSamples::const_iterator at);
  struct Expiring {
    HeldInstance* instance;
    HeldSamples::const_iterator sample;
  };
  /// Returns the first sample that has expired.
  std::optional<Expiring> expired(MonotonicTime now) const;
  /// Returns kNever if no sample expires.
  MonotonicTime next_expiry() const;
  void erase_all(HeldInstance& instance);
  /// Keeps a change for later, instead of the one kept before. Keeps none if there is no room.
  void hold_back(HeldInstance& instance, std::optional<Change> change,
                 const HeldShareOf& share = {});
  std::optional<Change> take_held_back(HeldInstance& instance);

  /// Does nothing if there is no room.
  void join(HeldInstance& instance, const Guid& writer, const HeldShareOf& share);
  /// Returns false if the writer was not one of the instance's writers.
  bool leave(HeldInstance& instance, const Guid& writer);
  /// The instances that the writer has joined.
  std::vector<InstanceHandle> joined_by(const Guid& writer) const {
    return joined_.instances_of(writer);
  }
  std::size_t joins() const { return joined_.size(); }

  /// Numbers samples in the order of their arrival. `arrivals` is the counter, which other readers
  /// may share.
  void order_by_arrival(std::uint64_t& arrivals) { arrivals_ = &arrivals; }
  bool is_ordered() const { return arrivals_ != nullptr; }
  /// True if any sample is in these states.
  bool any(const States& states) const;
  std::size_t samples() const { return samples_; }
  /// The most samples and octets that one identity can have, if no other has any.
  std::size_t most_samples_of_one() const {
    return shares_samples_ ? max_samples_ / 2 : max_samples_;
  }
  static constexpr std::size_t kMostOctetsOfOne = kMaxOctets / 2;
  std::size_t octets() const { return octets_; }

  /// Keeps the counts by state correct across any change to an instance. The instance must outlive
  /// this object.
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
  /// `freed`: octets that go at the same time; `own`: those of them of the same share.
  struct Freed {
    std::size_t octets = 0, own = 0;
  };
  bool has_room_for_octets(std::size_t octets, const HeldShareOf& share, const Freed& freed) const;
  void hold(const HeldShareOf& share, std::size_t octets);
  void let_go(const HeldShareOf& share, std::size_t octets);
  void count_sample(const HeldSample& sample, int sign);
  /// Where a sample belongs among those of its instance.
  HeldSamples::iterator place_of(HeldInstance& instance, const HeldSample& sample) const;

  const History history_;
  const std::size_t max_samples_, max_instances_, max_per_instance_;
  const bool by_source_, indexes_sources_, shares_, shares_samples_;
  std::uint64_t* arrivals_ = nullptr;
  LinkedList<HeldInstance> ready_, idle_;  ///< must outlive the instances that are in them
  std::map<InstanceHandle, HeldInstance> instances_;
  std::map<KeyHash, HeldInstance*> by_key_;
  std::map<GuidPrefix, std::size_t> of_identity_;  ///< number of instances; only if they are shared
  InstanceWriters joined_;
  std::map<std::pair<MonotonicTime, std::uint64_t>, Expiring> expiring_;
  std::uint64_t expiries_ = 0, places_ = 0;
  HeldSamples spare_;  ///< nodes for reuse, so that storing a sample allocates none
  std::size_t samples_ = 0, octets_ = 0;
  std::array<std::size_t, 12> counts_{};  ///< number of samples, by their three states
  std::uint64_t next_handle_ = 1;
};

}  // namespace ddssec::rtps
