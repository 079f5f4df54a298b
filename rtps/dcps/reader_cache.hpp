// What a DataReader holds: instances with their samples and states (DDS 1.4, 2.2.2.5.1), who owns
// them (2.2.3.9) and when they expire or miss their deadline. No I/O, clock or lock: the caller
// brings times and serializes calls.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <set>
#include <vector>

#include "rtps/dcps/link.hpp"
#include "rtps/dcps/status.hpp"
#include "rtps/filter/bound_filter.hpp"
#include "rtps/qos/qos.hpp"
#include "rtps/reliability/stateful_writer.hpp"

namespace ddssec::rtps {

/// The same moment by both clocks.
struct Moment {
  MonotonicTime now{};
  Time wall{};
};

/// What one read or take asks for.
struct Query {
  States states = {};
  std::size_t most = ~std::size_t{0};
  bool take = false;
  enum class Scope : std::uint8_t { all, instance, next_instance } scope = Scope::all;
  InstanceHandle instance = {};     ///< of `instance`; or the one after which the next is wanted
  BoundFilter* matching = nullptr;  ///< only samples with data that pass it; nullptr: all
};

class ReaderCache {
 public:
  /// Where RESOURCE_LIMITS says "unlimited", memory is bounded all the same.
  static constexpr std::size_t kMostSamples = 65536;
  static constexpr std::size_t kMostInstances = 65536;
  static constexpr std::size_t kMostOctets = std::size_t{256} << 20;

  /// The serialized key of a change, to show it when there is no data any more.
  using KeyOf = std::function<Bytes(const Change&)>;
  explicit ReaderCache(const Qos& qos, KeyOf key_of = nullptr);

  /// A matched writer, or its changed OWNERSHIP_STRENGTH.
  void set_writer(const Guid& writer, std::int32_t strength, Duration lifespan);
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
  void order_by_arrival(std::uint64_t& arrivals) { arrivals_ = &arrivals; }
  /// When the samples in these states arrived.
  std::vector<std::uint64_t> arrivals(const States& states) const;
  /// True if so many more samples can be stored, of whatever instance.
  bool has_room(std::size_t samples) const {
    return samples_ + samples <= most_samples_ || history_.kind == HistoryKind::keep_last;
  }
  /// Appends what is asked for to `out`, samples of one instance together.
  void select(const Query& query, const Moment& at, std::vector<OctetSample>& out);
  /// True if a select with these states would find something.
  bool any(const States& states) const;
  /// The same of a query; looks at the samples one by one if there is one.
  bool any(const States& states, BoundFilter* matching) const;

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

  std::size_t samples() const { return samples_; }
  std::size_t instances() const { return instances_.size(); }
  std::size_t octets() const { return octets_; }

 private:
  struct Held {
    Change change;
    bool is_read = false;
    bool valid = true;
    std::int32_t disposed_generations = 0, no_writers_generations = 0;
    MonotonicTime expires = kNever;
    std::uint64_t arrival = 0;  ///< if ordered
    std::int32_t generations() const { return disposed_generations + no_writers_generations; }
  };
  using HeldList = std::list<Held>;
  struct Instance {
    InstanceHandle handle;
    KeyHash key{};
    Payload key_value;
    InstanceState state = InstanceState::alive;
    ViewState view = ViewState::new_;
    std::int32_t disposed_generations = 0, no_writers_generations = 0;
    HeldList held;
    std::size_t unread = 0, invalid = 0;
    std::vector<Guid> writers;       ///< alive, and have not unregistered it
    std::optional<Guid> owner;       ///< EXCLUSIVE only
    std::optional<Time> seen_until;  ///< source time of the newest sample that was handed out
    MonotonicTime deadline = kNever;
    MonotonicTime quiet_until{};      ///< TIME_BASED_FILTER
    std::optional<Change> held_back;  ///< until then
    Link<Instance> ready{this};       ///< has samples
    Link<Instance> idle{this};        ///< has none and is not alive: the first to go
    Link<Instance> due{this};         ///< in the order of deadlines
    Link<Instance> quiet{this};       ///< in the order of quiet_until
    std::multimap<MonotonicTime, Instance*>::iterator purge;  ///< if purged
    bool purged = false;                                      ///< at a time of purges_
    std::size_t valid() const { return held.size() - invalid; }
  };
  struct Writer {
    std::int32_t strength = 0;
    Duration lifespan = kDurationInfinite;
  };
  /// Keeps the counts right over whatever happens to an instance while it lives.
  class Recount {
   public:
    Recount(ReaderCache& cache, Instance& instance) : cache_(cache), instance_(instance) {
      cache_.count(instance_, -1);
    }
    ~Recount() { cache_.count(instance_, 1); }
    Recount(const Recount&) = delete;
    Recount& operator=(const Recount&) = delete;

   private:
    ReaderCache& cache_;
    Instance& instance_;
  };

  Instance* find(const KeyHash& key);
  Instance* create(const Change& change);
  bool is_full(const Instance& instance) const;
  static HeldList::const_iterator oldest_of(const Instance& instance);
  static HeldList::const_iterator invalid_of(const Instance& instance);
  SampleRejectedReason rejects(const Instance* instance, const Change& change) const;
  bool may_own(const Instance& instance, const Guid& writer) const;
  bool is_too_old(const Instance& instance, const Change& change) const;
  MonotonicTime expiry_of(const Change& change, const Moment& at) const;
  void store_alive(Instance& instance, Change& change, MonotonicTime expires, MonotonicTime now);
  void store_end(Instance& instance, const Change& change, MonotonicTime now);
  void insert(Instance& instance, Held held);
  void add_invalid(Instance& instance, const Guid& writer, const std::optional<Time>& time);
  void revive(Instance& instance);
  void hold_back(Instance& instance, std::optional<Change> change);
  void begin_quiet(Instance& instance, MonotonicTime now);
  void join(Instance& instance, const Guid& writer);
  bool leave(Instance& instance, const Guid& writer, MonotonicTime now);
  void end(Instance& instance, InstanceState state, MonotonicTime now);
  void keep(Instance& instance);
  bool purge(MonotonicTime now);
  HeldList::iterator erase(Instance& instance, HeldList::const_iterator at);
  void settle(Instance& instance);
  void restart_deadline(Instance& instance, MonotonicTime now);
  void select_ordered(const Query& query, std::vector<OctetSample>& out);
  static bool is_asked_for(const Instance& instance, const Held& held, const Query& query);
  HeldList::iterator hand_out(Instance& instance, HeldList::iterator at, bool take,
                              std::vector<OctetSample>& out);
  void select_from(Instance& instance, const Query& query, std::vector<OctetSample>& out);
  std::int32_t strength_of(const Guid& writer) const;
  void count(const Instance& instance, int sign);

  const History history_;
  const std::size_t most_samples_, most_instances_, most_per_instance_;
  const bool exclusive_, by_source_;
  MonotonicTime deadline_ = kNever;  ///< period
  ReaderDataLifecycle lifecycle_;
  KeyOf key_of_;
  const bool reliable_;
  MonotonicTime separation_{};  ///< TIME_BASED_FILTER; 0: none
  std::uint64_t* arrivals_ = nullptr;
  std::multimap<MonotonicTime, Instance*> purges_;
  LinkedList<Instance> ready_, idle_, due_, quiet_;  ///< outlive the instances that are in them
  std::map<InstanceHandle, Instance> instances_;
  std::map<KeyHash, Instance*> by_key_;
  std::map<Guid, Writer> writers_;
  /// Which writer is among those of which instance, so that one that goes costs only its own.
  std::set<std::pair<Guid, InstanceHandle>> joined_;
  HeldList spare_;  ///< nodes of the past: a sample that comes allocates none
  std::size_t samples_ = 0, octets_ = 0;
  std::array<std::size_t, 12> counts_{};  ///< of samples, by their three states
  MonotonicTime next_expiry_ = kNever;
  std::uint64_t next_handle_ = 1;
};

}  // namespace ddssec::rtps
