// The samples of a DataReader. ReaderCache decides which changes are stored (HeldInstances holds
// them), which writer owns an instance (DDS 1.4, 2.2.3.9), and when samples expire or miss their
// deadline. No I/O, clock or lock: the caller passes times and serializes calls.
#pragma once

#include <functional>
#include <span>

#include "rtps/dcps/sample_selection.hpp"
#include "rtps/reliability/moment.hpp"

namespace ddssec::rtps {

/// Decides for one DataReader what becomes of each received change: stored, held back, dropped or
/// rejected.
class ReaderCache {
 public:
  /// Returns the serialized key of a change, which identifies the instance when there is no data
  /// any more.
  using KeyOf = std::function<Bytes(const Change&)>;
  /// With DESTINATION_ORDER BY_SOURCE_TIMESTAMP: how far a source time may be ahead of our clock. A
  /// later one is replaced by the time of arrival (DDS 1.4, 2.2.3.17), so that a sample from the
  /// far future does not suppress what others write to its instance.
  static constexpr std::chrono::seconds kMaxAhead{10};
  /// The largest number of missed deadlines that one call of expire_deadlines reports, and the
  /// pause before the next ones. A peer that has created many instances need not do anything more:
  /// each of them misses each deadline.
  static constexpr std::size_t kMaxMissed = 512;
  static constexpr MonotonicTime kMissedPause = std::chrono::milliseconds(1);
  /// `queries` are those of the reader's QueryConditions. They must outlive this object
  /// (HeldInstances).
  explicit ReaderCache(const Qos& qos, KeyOf key_of = nullptr, const Queries& queries = kNoQueries);

  /// Adds a matched writer, or changes its OWNERSHIP_STRENGTH. Its samples and new instances count
  /// for the share of `identity` (ParticipantCore::identity_of). If that is empty, they are not
  /// counted.
  void set_writer(const Guid& writer, std::int32_t strength, Duration lifespan,
                  const std::optional<GuidPrefix>& identity = {});
  /// Why a writer is lost. One that is not alive may return, with the same settings.
  enum class WriterLoss : std::uint8_t { unmatched, not_alive };
  /// Removes a writer from all its instances. Returns true if any state changed.
  bool lose_writer(const Guid& writer, WriterLoss loss, MonotonicTime now);

  /// Returns the time at which the LIFESPAN of its writer ends the change, or kNever.
  MonotonicTime expiry_of(const Change& change, const Moment& at) const;

  enum class StoreResult : std::uint8_t { stored, dropped, rejected };
  struct StoreReport {
    StoreResult outcome = StoreResult::stored;
    SampleRejectedReason reason = SampleRejectedReason::not_rejected;
    InstanceHandle instance;
    bool crowded = false;  ///< true if the limit is one that identities share
  };
  /// Stores the change, unless it is rejected: then nothing has changed, and it may be offered
  /// again. A change is dropped if readers must not see it: its writer is not the owner, or it is
  /// too late or expired.
  StoreReport store(Change& change, const Moment& at);
  /// Returns the rejection of a change that was rejected before, if there is still no room for it.
  std::optional<StoreReport> rejects_again(const Change& change, const Moment& at) const;

  /// Makes samples be read in the order of their arrival, whatever their instance (ordered access
  /// with TOPIC or GROUP scope). `arrivals` is the counter, which other readers may share.
  void order_by_arrival(std::uint64_t& arrivals) { held_.order_by_arrival(arrivals); }
  /// Returns whether these samples of a writer's identity can be stored (HeldInstances).
  Room room_for(const WantedRoom& wanted, const Guid& writer) const {
    const auto& of_writer = writer_of(writer);
    return held_.room_for(wanted, of_writer.share);
  }
  /// Handles a change that comes from its own writer after another writer delivered it. With
  /// OWNERSHIP EXCLUSIVE the writer gets its instance back, if it is stronger than the owner.
  /// Returns true if the change must be stored again, because the owner replaced it in the
  /// meantime.
  bool is_wanted_again(const Change& change);
  /// Appends the samples that match the query to `out`; samples of one instance are adjacent.
  void select(const SampleQuery& query, const Moment& at, std::vector<OctetSample>& out);
  /// True if a select with these states, and with this query if it is not nullptr, would find
  /// something.
  bool any(const States& states, const QueryMatches* matching = nullptr) const {
    return matching == nullptr ? held_.any(states) : matching->any(states);
  }

  /// Removes what LIFESPAN or READER_DATA_LIFECYCLE has ended. Returns true if it removed anything.
  bool expire(MonotonicTime now);
  /// Calls `missed` for each instance whose DEADLINE passed, and removes its owner. If there are
  /// more than kMaxMissed, the others follow after a pause.
  void expire_deadlines(MonotonicTime now, const std::function<void(InstanceHandle)>& missed);
  /// Returns the next time at which expire or expire_deadlines has work.
  MonotonicTime next_tick() const;
  /// Changes the DEADLINE period. The new period of each instance that is alive begins at `now`.
  void set_deadline(Duration period, MonotonicTime now);
  /// Sets the policy for instances that end from now on.
  void set_lifecycle(const ReaderDataLifecycle& lifecycle) { lifecycle_ = lifecycle; }

  /// Sets the separation of TIME_BASED_FILTER: a sample of an instance that arrives sooner than
  /// this after the previous one is dropped. A reliable reader gets the latest of them when the
  /// time has passed.
  void set_minimum_separation(Duration separation);
  /// Stores the samples that were held back until now. Returns true if there were any.
  bool release(const Moment& at);

  /// Returns HANDLE_NIL if the instance is not known.
  InstanceHandle lookup(const KeyHash& key) const;
  /// Returns the serialized key, or nullptr if the instance is not known.
  const Payload* key_value(InstanceHandle instance) const;

  /// Removes samples that were selected before, if they are still held. Looks once at each sample
  /// of their instances. Returns how many it removed.
  std::size_t discard(std::span<const OctetSample> samples);
  /// Returns the octets that the reader holds of one instance.
  std::size_t octets_of(const KeyHash& key) const;
  /// Removes everything about the instance, if it has ended.
  void forget_ended(const KeyHash& key);

  /// Returns the number of changes whose source time was more than kMaxAhead ahead; never reset.
  std::uint64_t times_ahead() const { return times_ahead_; }
  const HeldInstances& held() const { return held_; }

 private:
  using Instance = HeldInstance;
  using Recount = HeldInstances::Recount;
  struct Writer {
    std::int32_t strength = 0;
    Duration lifespan = kDurationInfinite;
    HeldShareOf share = {};
  };

  /// Returns the default values for a writer that is not matched.
  const Writer& writer_of(const Guid& guid) const;
  bool may_own(const Instance& instance, const Guid& writer) const;
  void limit_source_time(Change& change, const Moment& at);
  StoreReport store_first(Change& change, MonotonicTime expires, MonotonicTime now);
  StoreReport store_next(Instance& instance, Change& change, MonotonicTime expires,
                         MonotonicTime now);
  StoreReport insert(Instance& instance, Change& change, MonotonicTime expires, MonotonicTime now);
  StoreReport hold_back(Instance& instance, Change& change, MonotonicTime expires);
  void store_alive(Instance& instance, HeldSample sample, MonotonicTime now);
  void store_end(Instance& instance, const Change& change, MonotonicTime now);
  /// Moves what the instance holds back to its samples. Returns false if it was dropped instead.
  bool store_held_back(Instance& instance, MonotonicTime now);
  bool leave(Instance& instance, const Guid& writer, MonotonicTime now);
  void end(Instance& instance, InstanceState state, MonotonicTime now);
  bool purge(MonotonicTime now);
  void restart_deadline(Instance& instance, MonotonicTime now);
  /// Begins to filter the samples of the instance until the separation ends. A sample that is held
  /// back is stored at `release_at`.
  void begin_quiet(Instance& instance, MonotonicTime now, MonotonicTime release_at);

  const bool is_exclusive_, is_by_source_, is_reliable_;
  MonotonicTime deadline_ = kNever;  ///< the DEADLINE period
  MonotonicTime next_missed_{};      ///< before this time, no missed deadline is reported
  ReaderDataLifecycle lifecycle_;
  KeyOf key_of_;
  MonotonicTime separation_{};  ///< TIME_BASED_FILTER; 0 without a filter
  std::uint64_t times_ahead_ = 0;
  HeldShares shares_;
  std::map<Guid, Writer> writers_;
  InstanceTimes purges_;
  LinkedList<Instance> due_, quiet_;
  HeldInstances held_;  ///< declared last, because its instances leave the lists above
};

}  // namespace ddssec::rtps
