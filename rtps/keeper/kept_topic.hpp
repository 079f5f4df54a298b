// One topic of a keeper: a reader for all its durable writers, and a writer for late joiners.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <set>

#include "rtps/dcps/liveliness.hpp"
#include "rtps/dcps/participant_context.hpp"
#include "rtps/dcps/seen_originals.hpp"
#include "rtps/durability/durable_store.hpp"
#include "rtps/keeper/instance_owners.hpp"
#include "rtps/keeper/request_pace.hpp"
#include "rtps/participant/endpoint_listener.hpp"

namespace ddssec::rtps {

/// Keeps the samples of the writers with exactly the same partitions and data tags. So the samples
/// reach no reader that the original writer does not match. A sample is acknowledged only when it
/// is stored, because a writer may leave once its samples are acknowledged. Late joiners get the
/// samples that are stored or are being stored: the limits of the store, with the shares of all
/// identities, are those of the memory as well. A sample above the share of its identity stays with
/// its writer until there is room. With OWNERSHIP EXCLUSIVE it keeps what a reader would have seen:
/// the samples of the owner of each instance. The participant calls it with its lock held.
class KeptTopic final : private EndpointListener, private TimedObject {
 public:
  /// How long the writers that own stored instances have to come back after the topic was opened.
  /// Until then, samples of these instances by other writers wait.
  static constexpr MonotonicTime kReturn = std::chrono::seconds(10);

  /// `writer` is the announcement of one of its writers. `held` limits what the readers of all
  /// topics hold. `on_first_sample` is called with the lock held when there is something to keep.
  KeptTopic(ParticipantContext& context, DurableStore& store, std::shared_ptr<HeldOctets> held,
            EndpointData writer, std::function<void()> on_first_sample);
  ~KeptTopic() override;

  /// Opens the stream, and creates the writer and the reader. The caller does not hold the lock.
  /// Errors: those of DurableStore::open_stream, RtpsParticipant::create_writer and create_reader.
  Status open(DomainId domain, const std::string& domain_tag);
  /// Returns what the keeper's functions of these names return, for this topic. The caller holds
  /// the lock.
  std::uint64_t without_key() const { return without_key_; }
  std::uint64_t dropped() const { return dropped_; }
  /// Returns the number of samples that wait for room, or until it is known who owns their
  /// instance.
  std::uint64_t waiting() const;
  /// Returns the number of the samples that waited when their writers left.
  std::uint64_t abandoned() const;
  /// Returns the number of samples that late joiners get, and the octets of their payloads.
  std::uint64_t served() const;
  std::uint64_t served_octets() const;
  bool has_samples() const { return has_samples_; }
  const std::string& name() const { return first_writer_.topic_name; }
  /// True if it has samples, or if a writer whose samples are kept has matched.
  bool is_in_use() const { return has_samples_ || !writers_.empty(); }
  /// True if a topic that was created for that writer would be kept in the same way.
  bool is_made_for(const EndpointData& writer) const;

 private:
  bool on_change(Change& change) override;
  void on_matched(const EndpointData& remote) override;
  void on_unmatched(const Guid& remote) override;
  void on_incompatible_qos(const Guid&, const QosMismatch&) override {}
  void on_inconsistent_topic(const EndpointData&) override {}
  void on_sample_lost(std::int64_t) override {}
  void on_sample_dropped(const Guid& writer, std::uint32_t octets) override;
  void on_time(MonotonicTime now) override;
  StatefulWriter& server() const;
  /// Stops serving the samples that the store removed.
  void discard(const std::vector<std::int64_t>& rows);
  void schedule_next_call(MonotonicTime now);
  SequenceNumber first_unstored(const Guid& writer, SequenceNumber next) const;
  /// Acknowledges samples that were stored. Returns false if none was.
  bool acknowledge_stored();
  void request_waiting_samples(MonotonicTime now);
  /// Lets the writer offer the change again later.
  bool defer(MonotonicTime now);
  void on_signal(const Guid& writer, std::shared_ptr<LivelinessSignal> signal) override;
  void on_alive(const Guid& writer) override;
  void on_acknowledged() override {}
  /// Describes a local endpoint on this topic with these policies.
  EndpointDescription description_with(Qos qos) const;
  void expect_owners(const std::vector<Change>& history);
  InstanceOwners::Claim claim(const Change& change);
  /// Stores the change. Returns false if there is no room.
  bool keep(Change& change);
  /// Makes the change wait until its identity has room.
  bool wait_for_room(const Guid& writer, bool has_no_share);
  /// Makes the announced LIFESPAN at least as long as this one. Readers end samples when the
  /// announced LIFESPAN ends, so it is the longest one of the samples that they get.
  void extend_lifespan(Duration lifespan);
  bool was_heard(const Change& change) const;
  /// False if the writer reaches other readers, or needs other permissions.
  bool has_scope_of(const EndpointData& writer) const;
  /// Returns the identity whose share of the store a sample uses.
  std::optional<GuidPrefix> identity_of(const GuidPrefix& sender) const;

  ParticipantContext& context_;
  DurableStore& store_;
  const std::shared_ptr<HeldOctets> held_;
  const EndpointData first_writer_;
  const bool with_key_;
  std::optional<StreamId> stream_;
  Guid reader_, writer_;
  SeenOriginals seen_;
  std::map<Guid, HeardWriter> heard_;  ///< as heard before the topic was opened
  std::uint64_t without_key_ = 0, dropped_ = 0;
  std::function<void()> on_first_sample_;
  bool has_samples_ = false;
  Duration longest_lifespan_, announced_lifespan_;
  std::set<Guid> writers_;                ///< writers that matched, and whose samples are kept
  std::optional<InstanceOwners> owners_;  ///< only with OWNERSHIP EXCLUSIVE
  LivelinessMonitor liveliness_;          ///< the same: owners that are not alive own nothing
  bool has_deferred_ = false;  ///< true if a change waits for room, or for an owner to come back
  /// Writers that have waited. Until they have caught up, all that they write counts as late
  /// (StoredChange).
  std::set<Guid> have_waited_;
  /// Writers whose next change has no share of the store. It is requested again, because a change
  /// that its writer has replaced need not wait.
  std::set<Guid> without_share_;
  RequestPace pace_;
  MonotonicTime next_late_check_{};
  /// A change that is being stored.
  struct UnstoredChange {
    std::uint64_t number;  ///< see DurableStore::append
    SequenceNumber change;
  };
  std::map<Guid, std::deque<UnstoredChange>> unstored_;  ///< by writer
  /// The samples that are served, by their rows in the store.
  std::map<std::int64_t, SequenceNumber> rows_;
};

}  // namespace ddssec::rtps
