// The instances that a reader knows, with their samples and states (DDS 1.4, 2.2.2.5.1), within
// RESOURCE_LIMITS. ReaderCache decides which changes are stored and when they end. No I/O, clock or
// lock.
#pragma once

#include "rtps/dcps/arrival_order.hpp"
#include "rtps/dcps/instance_writers.hpp"
#include "rtps/dcps/state_counts.hpp"
#include "rtps/qos/qos.hpp"
#include "rtps/reliability/change.hpp"

namespace ddssec::rtps {

class QueryMatches;
/// The queries of a reader's QueryConditions.
using Queries = std::vector<QueryMatches*>;
inline const Queries kNoQueries = {};

/// The time when samples that belong together can be stored.
enum class Room : std::uint8_t {
  now,
  later,  ///< when samples that the reader holds have been taken
  never,  ///< not even if the reader held no other samples
};

/// The room that samples that belong together need.
struct WantedRoom {
  std::size_t samples = 0, octets = 0;
  std::map<KeyHash, std::size_t> instances = {};  ///< the number of samples of each instance
};

/// The instances and samples of one reader, and the limits that they count against. ReaderCache
/// owns it.
class HeldInstances {
 public:
  /// The limits that apply if RESOURCE_LIMITS says "unlimited", so that memory stays bounded. No
  /// identity may have more samples than are still free, nor the first sample of more instances
  /// than are still free. So there is always room for another identity.
  static constexpr std::size_t kMaxSamples = 131072;
  static constexpr std::size_t kMaxInstances = 131072;
  /// Limit for the octets of samples and keys, with the same rule.
  static constexpr std::size_t kMaxOctets = std::size_t{256} << 20;

  /// Keeps these queries up to date. The list, which may change, must outlive this object.
  explicit HeldInstances(const Qos& qos, const Queries& queries = kNoQueries);

  /// Returns nullptr if the instance is not known.
  HeldInstance* find(const KeyHash& key) const;
  HeldInstance* find(InstanceHandle handle);
  const std::map<InstanceHandle, HeldInstance>& all() const { return instances_; }
  std::map<InstanceHandle, HeldInstance>& all() { return instances_; }
  /// Returns the instances with samples. An instance may be removed while the list is iterated.
  const LinkedList<HeldInstance>& ready() const { return ready_; }

  struct Rejection {
    SampleRejectedReason reason = SampleRejectedReason::not_rejected;
    bool crowded = false;  ///< true if the limit is one that identities share
  };
  /// Returns the limit that leaves no room for the change, or not_rejected. `instance` is that of
  /// the change; nullptr means a new one with a key of `key_octets`. `share` is that of the
  /// writer's identity. The change may be the one that the instance holds back.
  Rejection rejects(const HeldInstance* instance, const Change& change, const HeldShareOf& share,
                    std::size_t key_octets) const;
  /// True if the next sample replaces the oldest one (KEEP_LAST).
  bool is_full(const HeldInstance& instance) const;
  /// Returns whether these samples of an identity can be stored beside those that are held: now,
  /// later or never. The octets of new keys and the places of InstanceWriters are not counted.
  Room room_for(const WantedRoom& wanted, const HeldShareOf& share) const;
  /// Creates an instance. Call it only if `rejects` found room. May remove the oldest idle
  /// instance to make room.
  HeldInstance& create(const KeyHash& key, Payload key_value, const HeldShareOf& share);
  /// Moves the instance to the lists where it belongs, or forgets it. Call it after a change
  /// to the instance.
  void settle(HeldInstance& instance);
  /// Removes the instance, which must not have samples. A change that it holds back is dropped.
  void forget(HeldInstance& instance);

  void insert(HeldInstance& instance, HeldSample held);
  /// Inserts a sample without data that reports the end of the instance. There is at most one for
  /// each instance, and it reports the latest state.
  void insert_invalid(HeldInstance& instance, const Guid& writer, const std::optional<Time>& time);
  HeldSamples::iterator erase(HeldInstance& instance, HeldSamples::const_iterator at);
  struct ExpiringSample {
    HeldInstance* instance;
    HeldSamples::const_iterator sample;
  };
  /// Returns the first sample that has expired.
  std::optional<ExpiringSample> expired(MonotonicTime now) const;
  /// Returns kNever if no sample expires.
  MonotonicTime next_expiry() const;
  void erase_all(HeldInstance& instance);
  void mark_read(HeldInstance& instance, HeldSample& sample);
  /// True if `hold_back` finds room.
  bool can_hold_back(const HeldInstance& instance, const Change& change,
                     const HeldShareOf& share) const;
  /// Keeps a change for later, instead of the one kept before. The instance is not forgotten while
  /// it holds a change back. Returns false if there is no room: then nothing has changed.
  bool hold_back(HeldInstance& instance, Change& change, const HeldShareOf& share = {},
                 MonotonicTime expires = kNever);
  std::optional<Change> take_held_back(HeldInstance& instance);

  /// Notes that the writer has the instance. Does nothing if there is no room.
  void join(HeldInstance& instance, const Guid& writer, const HeldShareOf& share);
  /// Notes that the writer no longer has the instance. Returns false if it did not have it. If no
  /// other writer of its identity has the instance, the instance counts for the identity of another
  /// writer. If none of these has room for it, they leave as well, and a change that the instance
  /// holds back is dropped.
  bool leave(HeldInstance& instance, const Guid& writer);
  /// Returns the instances that the writer has joined.
  std::vector<InstanceHandle> joined_by(const Guid& writer) const {
    return joined_.instances_of(writer);
  }
  std::size_t joins() const { return joined_.size(); }

  /// Numbers samples in the order of their arrival. `arrivals` is the counter, which other readers
  /// may share.
  void order_by_arrival(std::uint64_t& arrivals) { arrivals_ = &arrivals; }
  bool is_ordered() const { return arrivals_ != nullptr; }
  /// Returns the samples in this order; empty unless they are ordered.
  const ArrivalOrder& order() const { return order_; }
  /// True if any sample is in these states.
  bool any(const States& states) const { return counts_.any(states); }
  std::size_t samples() const { return samples_; }
  /// Returns the most samples that one identity can have if no other has any; kMaxOctetsOfOne is
  /// the same for octets.
  std::size_t max_samples_of_one() const {
    return shares_samples_ ? max_samples_ / 2 : max_samples_;
  }
  static constexpr std::size_t kMaxOctetsOfOne = kMaxOctets / 2;
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
  Room room_for_instances(const WantedRoom& wanted, const HeldShareOf& share) const;
  /// True if the instance can count for this identity, or already counts for another one that has
  /// it. nullptr means a new instance, whose key is not counted.
  bool can_pay(const HeldInstance* instance, const HeldShareOf& share) const;
  /// What is released at the same time: `octets` in all, and of these `own` that belong to the same
  /// share.
  struct FreedOctets {
    std::size_t octets = 0, own = 0;
  };
  bool has_room_for_octets(std::size_t octets, const HeldShareOf& share,
                           const FreedOctets& freed) const;
  void hold(const HeldShareOf& share, std::size_t octets);
  void release(const HeldShareOf& share, std::size_t octets);
  void count_sample(const HeldSample& sample, int sign);

  const History history_;
  const std::size_t max_samples_, max_instances_, max_per_instance_;
  const bool is_by_source_, indexes_sources_, shares_, shares_samples_;
  std::uint64_t* arrivals_ = nullptr;
  ArrivalOrder order_;
  const Queries& queries_;
  LinkedList<HeldInstance> ready_, idle_;  ///< must outlive the instances that are in them
  std::map<InstanceHandle, HeldInstance> instances_;
  std::map<KeyHash, HeldInstance*> by_key_;
  InstanceWriters joined_;
  std::map<std::pair<MonotonicTime, std::uint64_t>, ExpiringSample> expiring_;
  std::uint64_t expiries_ = 0, places_ = 0;
  HeldSamples spare_;  ///< nodes for reuse, so that storing a sample allocates none
  std::size_t samples_ = 0, octets_ = 0;
  StateCounts counts_;
  std::uint64_t next_handle_ = 1;
};

}  // namespace ddssec::rtps
