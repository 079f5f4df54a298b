// What a DataReader holds: which changes enter (HeldInstances has them then), who owns an instance
// (DDS 1.4, 2.2.3.9), and when samples expire or miss their deadline. No I/O, clock or lock: the
// caller brings times and serializes calls.
#pragma once

#include <functional>

#include "rtps/dcps/sample_selection.hpp"

namespace ddssec::rtps {

/// The same moment by both clocks.
struct Moment {
  MonotonicTime now{};
  Time wall{};
};

class ReaderCache {
 public:
  /// The serialized key of a change, to show it when there is no data any more.
  using KeyOf = std::function<Bytes(const Change&)>;
  explicit ReaderCache(const Qos& qos, KeyOf key_of = nullptr);

  /// A matched writer, or its changed OWNERSHIP_STRENGTH. `identity`: whose share of the instances
  /// its new ones take (ParticipantCore::identity_of); nothing: they are not counted.
  void set_writer(const Guid& writer, std::int32_t strength, Duration lifespan,
                  const std::optional<GuidPrefix>& identity = {});
  /// Is gone, or not alive any more: it leaves all its instances. True if any state changed.
  bool lose_writer(const Guid& writer, bool unmatched, MonotonicTime now);

  enum class Outcome : std::uint8_t { stored, dropped, rejected };
  struct Stored {
    Outcome outcome = Outcome::stored;
    SampleRejectedReason reason = SampleRejectedReason::not_rejected;
    InstanceHandle instance;
  };
  /// Takes the change, unless rejected: then nothing has changed, and it may be offered again.
  /// Dropped is what a reader must not see: another owner's, too late, expired.
  Stored store(Change& change, const Moment& at);

  /// Samples come out in the order in which they came in, whatever their instance (ordered access
  /// with TOPIC or GROUP scope). `arrivals` counts them, also those of other readers.
  void order_by_arrival(std::uint64_t& arrivals) { held_.order_by_arrival(arrivals); }
  /// When the samples in these states arrived.
  std::vector<std::uint64_t> arrivals(const States& states) const {
    return rtps::arrivals(held_, states);
  }
  /// Whether so many more samples can be stored, of whatever instance.
  Room room_for(std::size_t samples, std::size_t octets) const {
    return held_.room_for(samples, octets);
  }
  /// As many samples as it can hold.
  std::size_t max_samples() const { return held_.max_samples(); }
  /// Appends what is asked for to `out`, samples of one instance together.
  void select(const Query& query, const Moment& at, std::vector<OctetSample>& out);
  /// True if a select with these states would find something.
  bool any(const States& states) const { return held_.any(states); }
  /// The same of a query; looks at the samples one by one if there is one.
  bool any(const States& states, BoundFilter* matching) const {
    return rtps::any(held_, states, matching);
  }

  /// Removes what LIFESPAN or READER_DATA_LIFECYCLE ended; true if there was any.
  bool expire(MonotonicTime now);
  /// Calls `missed` for each instance whose DEADLINE passed, and takes it from its owner.
  void check_deadlines(MonotonicTime now, const std::function<void(InstanceHandle)>& missed);
  /// The next moment at which expire or check_deadlines has something to do.
  MonotonicTime next_tick() const;
  void set_deadline(Duration period, MonotonicTime now);
  /// For instances that end from now on.
  void set_lifecycle(const ReaderDataLifecycle& lifecycle) { lifecycle_ = lifecycle; }

  /// TIME_BASED_FILTER: samples of an instance that come sooner than this after the last are
  /// dropped; a reliable reader gets the latest of them when the time is over.
  void set_minimum_separation(Duration separation);
  /// Stores what was held back until now; true if there was any.
  bool release(const Moment& at);

  /// HANDLE_NIL if the instance is not known.
  InstanceHandle lookup(const KeyHash& key) const;
  /// The serialized key; nullptr for an unknown instance.
  const Payload* key_value(InstanceHandle instance) const;

  /// Of one instance.
  std::size_t octets_of(const KeyHash& key) const;
  /// As if the instance had never been, if it has ended.
  void forget_ended(const KeyHash& key);

  std::size_t samples() const { return held_.samples(); }
  std::size_t instances() const { return held_.all().size(); }
  std::size_t octets() const { return held_.octets(); }

 private:
  using Instance = HeldInstance;
  using Recount = HeldInstances::Recount;
  struct Writer {
    std::int32_t strength = 0;
    Duration lifespan = kDurationInfinite;
    std::optional<GuidPrefix> identity = {};
  };

  bool may_own(const Instance& instance, const Guid& writer) const;
  std::int32_t strength_of(const Guid& writer) const;
  std::optional<GuidPrefix> identity_of(const Guid& writer) const;
  bool is_too_old(const Instance& instance, const Change& change) const;
  MonotonicTime expiry_of(const Change& change, const Moment& at) const;
  void store_alive(Instance& instance, Change& change, MonotonicTime expires, MonotonicTime now);
  void store_end(Instance& instance, const Change& change, MonotonicTime now);
  void revive(Instance& instance);
  bool leave(Instance& instance, const Guid& writer, MonotonicTime now);
  void end(Instance& instance, InstanceState state, MonotonicTime now);
  bool purge(MonotonicTime now);
  void restart_deadline(Instance& instance, MonotonicTime now);
  void begin_quiet(Instance& instance, MonotonicTime now);

  const bool exclusive_, by_source_, reliable_;
  MonotonicTime deadline_ = kNever;  ///< period
  ReaderDataLifecycle lifecycle_;
  KeyOf key_of_;
  MonotonicTime separation_{};  ///< TIME_BASED_FILTER; 0: none
  std::map<Guid, Writer> writers_;
  InstanceTimes purges_;
  LinkedList<Instance> due_, quiet_;
  HeldInstances held_;  ///< its instances leave the lists above
};

}  // namespace ddssec::rtps
