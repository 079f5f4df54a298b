// A durability service (DDS 1.4, 2.2.3.4): keeps what TRANSIENT and PERSISTENT writers of a domain
// write and gives it to late joiners, whether those writers are still there or not.
#pragma once

#include "rtps/dcps/domain_participant.hpp"

namespace ddssec::rtps {

class KeptTopic;

struct KeeperOptions {
  std::string store = {};  ///< a file that outlives the keeper; empty: memory
  std::size_t store_octets = SampleStore::kDefaultOctets;
  std::vector<std::string> topics = {"*"};  ///< names, which may have wildcards
};

/// A participant of its own. It needs no types: what it keeps are octets, with the key hashes that
/// our durable writers send. Each sample says who wrote it (ORIGINAL_WRITER_INFO), so that our
/// readers get none twice; other vendors' readers, which do not look at that, get twice what a
/// writer that is still there has kept for them as well. The first writer of a topic that access
/// control lets write to it says how the topic is kept, and how much by its DURABILITY_SERVICE. A
/// topic is remembered from its first sample on; until then it gives way to others, and goes when
/// the writer that announced it goes. One keeper a file.
class Keeper final : private DataReaderListener {
 public:
  /// What one identity announced first takes no more places than are free, so that there is always
  /// room for another one: up to half of all.
  static constexpr std::size_t kMostTopics = 512;

  /// What the store has of before is served at once. Errors: those of DomainParticipant::create and
  /// of DurableStore::open.
  static Result<std::unique_ptr<Keeper>> create(DomainParticipantOptions options,
                                                KeeperOptions keeps,
                                                const Environment& environment);
  ~Keeper() override;

  /// Topics (of different types and partitions) that are kept.
  std::size_t topics() const;
  /// Samples that were not kept: of a type with keys, and without key hash.
  std::uint64_t without_key() const;
  /// Samples that were not kept: larger than readers take, or beyond DURABILITY_SERVICE.
  std::uint64_t dropped() const;
  std::uint64_t left_out() const { return store_->left_out(); }
  /// Samples that are not in the store yet, and were not acknowledged.
  std::uint64_t unstored() const { return store_->pending(); }
  /// All that came before is stored. Errors: those of DurableStore::flush.
  Status flush(std::chrono::nanoseconds most) { return store_->flush(most); }
  /// See DomainParticipant.
  void poll(std::chrono::nanoseconds timeout) { participant_->poll(timeout); }

 private:
  Keeper(std::unique_ptr<DomainParticipant> participant, std::unique_ptr<DurableStore> store,
         std::vector<std::string> topics);
  /// Serves what the store knows, and listens for more.
  Status start();
  void on_data_available(AnyDataReader& reader) override;
  bool wants(const EndpointData& writer) const;
  /// Keeps the writer's topic if it is still there and may write to it.
  void consider(const Guid& writer);
  /// What the writer announced; the prefix is that of its identity. Nothing: it is gone, not wanted
  /// or may not write.
  std::optional<EndpointData> admitted(const Guid& writer) const;
  /// What the store has of before. Errors: those of keep.
  Status keep_known(const Change& announced);
  /// Keeps the topic from now on, unless it does. `announcer`: nothing if the store knows it as
  /// well. Errors: rtps_store_failed, those of KeptTopic::open.
  Status keep(const EndpointData& writer, const std::optional<Guid>& announcer);
  /// What is kept with that key stays as it is.
  bool is_settled(const KeyHash& key, const EndpointData& writer) const;
  /// Topics without samples whose announcers are gone; other writers on them are considered anew.
  void replace_abandoned();
  bool has_samples(const KeptTopic& topic) const;
  /// Their names.
  std::set<std::string> remove_abandoned();
  std::vector<Guid> writers_on(const std::set<std::string>& topics) const;
  /// False: all places that `identity` may have are taken by topics with samples.
  bool make_room(const GuidPrefix& identity);
  template <class Count>
  std::uint64_t sum(Count count) const;

  std::unique_ptr<DomainParticipant> participant_;
  std::unique_ptr<DurableStore> store_;
  const std::vector<std::string> patterns_;
  StreamId known_;  ///< of announcements of what is kept
  struct Entry {
    std::unique_ptr<KeptTopic> topic;
    GuidPrefix identity;  ///< of the announcer
    Guid announcer;       ///< the writer that it was made for; of no use with samples
  };
  mutable std::mutex mutex_;  ///< of topics_
  std::map<KeyHash, Entry> topics_;
};

}  // namespace ddssec::rtps
