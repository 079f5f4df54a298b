// A durability service (DDS 1.4, 2.2.3.4): stores the samples of TRANSIENT and PERSISTENT writers
// of a domain and gives them to late joiners, whether the writers still exist or not.
#pragma once

#include "base/plugin_services.hpp"
#include "rtps/dcps/domain_participant.hpp"
#include "rtps/durability/durable_store.hpp"

namespace ddssec::rtps {

class KeptTopic;
class RefusedWriters;

/// What a keeper keeps, and where.
struct KeeperOptions {
  std::string store = {};  ///< path of a file that outlives the keeper; memory if empty
  std::size_t store_octets = SampleStore::kDefaultOctets;
  std::vector<std::string> topics = {"*"};  ///< topic names, which may have wildcards
};

/// A durability service with a participant of its own. It needs no types, because it stores octets
/// with the key hashes that durable writers of ddssec send.
/// - Each sample names its original writer (ORIGINAL_WRITER_INFO), so that readers of ddssec get no
///   sample twice. Readers of other vendors do not evaluate this. They get a sample twice if its
///   writer still exists and has kept it as well.
/// - Writers with different partitions or data tags are kept apart, each with its own reader and
///   writer. In a store, so are domain tags. A writer that has only partitions with wildcards is
///   not kept.
/// - With OWNERSHIP EXCLUSIVE it keeps what a reader sees: the samples of the strongest living
///   writer of each instance. Samples that a weaker one writes meanwhile are not kept.
/// - The first writer that access control permits to write to a topic determines how the topic is
///   kept; its DURABILITY_SERVICE determines how much.
/// - A topic is remembered from its first sample on. Until then it can be replaced by others, and
///   is removed when the writer that announced it is removed.
/// - A topic that cannot be kept is named in an event, and the others are kept. If only room is
///   missing, it is kept as soon as there is some.
/// - Only one keeper can use a file. Samples that were kept with security are not served without
///   it, and vice versa.
class Keeper final : private DataReaderListener {
 public:
  /// The largest number of kept topics. The topics that one identity announced first take no more
  /// places than are free. That is at most half of all, so there is always room for another
  /// identity.
  static constexpr std::size_t kMaxTopics = 512;

  /// Creates a keeper. Samples of the wanted topics that are already in the store are served at
  /// once. Errors: those of DomainParticipant::create and of DurableStore::open,
  /// rtps_store_unusable.
  static Result<std::unique_ptr<Keeper>> create(DomainParticipantOptions options,
                                                KeeperOptions keeps,
                                                const PluginServices& services);
  ~Keeper() override;

  /// Returns the number of topics (of different types and partitions) that are kept.
  std::size_t topics() const;
  /// Returns the number of samples that were not kept because their type has keys and they have no
  /// key hash.
  std::uint64_t without_key() const;
  /// Returns the number of samples that were not kept: dropped() because they were larger than
  /// readers accept, left_out() because of the limits of DURABILITY_SERVICE.
  std::uint64_t dropped() const;
  std::uint64_t left_out() const;
  /// Returns the number of samples that late joiners get, and served_octets() the octets of their
  /// payloads. These are at most what the store holds.
  std::uint64_t served() const;
  std::uint64_t served_octets() const;
  /// Returns the number of samples that still waited for room when their writers left. They are not
  /// kept and were never acknowledged. A writer that comes back offers them again.
  std::uint64_t abandoned() const;
  /// Returns the number of samples that are not in the store yet, and so were not acknowledged.
  /// Those that wait for room in the share of their identity count, even if only their writers have
  /// them.
  std::uint64_t unstored() const;
  /// Waits until everything that arrived before is stored. Errors: those of DurableStore::flush.
  Status flush(std::chrono::nanoseconds timeout) { return store_->flush(timeout); }
  /// Does the work that is due, for a keeper whose participant has no thread of its own.
  void poll(std::chrono::nanoseconds timeout) { participant_->poll(timeout); }

 private:
  Keeper(std::unique_ptr<DomainParticipant> participant, std::unique_ptr<DurableStore> store,
         std::vector<std::string> topics);
  /// Serves what is in the store, and listens for new writers.
  Status start();
  void on_data_available(AnyDataReader& reader) override;
  bool wants(const EndpointData& writer) const;
  /// Keeps the writer's topic if the writer still exists and may write to it.
  void consider(const Guid& writer);
  /// Returns the writer's announcement, with the prefix of its identity. Empty if the writer is
  /// gone or is not wanted.
  std::optional<EndpointData> wanted(const Guid& writer) const;
  bool may_write(const Guid& writer) const;
  /// Keeps a topic that is already in the store. If it cannot be kept, the others still are.
  void keep_known(const Change& announced);
  /// Raises the event that the writer's topic is not kept.
  void report(const Error& error, const EndpointData& writer) const;
  /// Considers a refused writer again. Returns false if it is still refused.
  bool retry(const Guid& writer);
  bool retry_known(const Guid& writer, const EndpointData& announced);
  /// Keeps the topic from now on, if it is not kept yet. `announcer` is empty if the topic is
  /// already in the store. Errors: rtps_store_failed, those of KeptTopic::open.
  Status keep(const EndpointData& writer, const std::optional<Guid>& announcer);
  /// True if the topic with that key is kept and does not change.
  bool is_settled(const KeyHash& key, const EndpointData& writer) const;
  /// Removes topics without samples whose announcers are gone, and considers other writers on them.
  void replace_abandoned();
  bool has_samples(const KeptTopic& topic) const;
  /// Returns the names of the removed topics.
  std::set<std::string> remove_abandoned();
  std::vector<Guid> writers_on(const std::set<std::string>& topics) const;
  /// Makes room for one more topic of `identity`: a topic without samples is removed if its
  /// identity has more topics. Returns false if there is none.
  bool make_room(const GuidPrefix& identity);
  /// Considers the writers of the topic with that name again, because the topic was removed to make
  /// room.
  void report_replaced(const std::string& name);
  template <class Count>
  std::uint64_t sum(Count count) const;

  std::unique_ptr<DomainParticipant> participant_;
  ParticipantContext& context_;  // of participant_
  std::unique_ptr<DurableStore> store_;
  /// The octets that all topics hold out of order, in fragments or because they wait for room.
  const std::shared_ptr<HeldOctets> held_ = std::make_shared<HeldOctets>();
  const std::vector<std::string> patterns_;
  std::string domain_tag_;
  StreamId known_;  ///< stream of the announcements of the kept topics
  struct Entry {
    std::unique_ptr<KeptTopic> topic;
    GuidPrefix identity;  ///< identity of the announcer
    Guid announcer;  ///< the writer that the topic was created for; not used once there are samples
  };
  mutable std::mutex mutex_;  ///< protects topics_ and refused_known_
  std::map<KeyHash, Entry> topics_;
  /// Topics in the store that could not be kept at the start, by the writers that announced them.
  std::map<Guid, EndpointData> refused_known_;
  std::unique_ptr<RefusedWriters> refused_;  ///< its thread uses all of the above
};

}  // namespace ddssec::rtps
