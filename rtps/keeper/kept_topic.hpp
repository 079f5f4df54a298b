// What a keeper has of one topic: a reader of all its durable writers, and a writer for late
// joiners.
#pragma once

#include <deque>
#include <functional>
#include <set>

#include "rtps/dcps/participant_context.hpp"
#include "rtps/dcps/seen_originals.hpp"
#include "rtps/durability/durable_store.hpp"

namespace ddssec::rtps {

/// What is taken from a writer is acknowledged when it is stored, and not before: a writer whose
/// samples are acknowledged may leave. Called by the participant, with its lock held.
class KeptTopic final : private EndpointListener, private Timed {
 public:
  /// `writer`: an announcement of one of its writers. `on_first_sample`, with the lock held: from
  /// now on there is something to keep.
  KeptTopic(ParticipantContext& context, DurableStore& store, EndpointData writer,
            std::function<void()> on_first_sample);
  ~KeptTopic() override;

  /// Without the lock. Errors: those of DurableStore::open_stream, Participant::create_writer and
  /// create_reader.
  Status open(DomainId domain);
  /// With the lock.
  std::uint64_t without_key() const { return without_key_; }
  std::uint64_t dropped() const { return dropped_; }
  bool has_samples() const { return has_samples_; }
  const std::string& name() const { return like_.topic_name; }
  /// A writer that may write to it matched, or it has samples.
  bool is_in_use() const { return has_samples_ || !writers_.empty(); }
  /// A topic that was made for that writer would be kept in the same way.
  bool is_made_for(const EndpointData& writer) const;

 private:
  bool on_change(Change& change) override;
  void on_matched(const EndpointData& remote) override;
  void on_unmatched(const Guid& remote) override { writers_.erase(remote); }
  void on_incompatible_qos(const Guid&, const QosMismatch&) override {}
  void on_inconsistent_topic(const EndpointData&) override {}
  void on_sample_lost(std::int64_t) override {}
  void on_sample_dropped(const Guid& writer, std::uint32_t octets) override;
  void on_time(MonotonicTime now) override;
  SequenceNumber first_unstored(const Guid& writer, SequenceNumber next);
  void on_alive(const Guid&) override {}
  void on_acknowledged() override {}
  EndpointRequest request(Qos qos) const;
  /// Whose share of the store a sample takes.
  std::optional<GuidPrefix> identity_of(const GuidPrefix& sender) const;

  ParticipantContext& context_;
  DurableStore& store_;
  const EndpointData like_;
  const bool with_key_;
  std::optional<StreamId> stream_;
  Guid reader_, writer_;
  SeenOriginals seen_;
  std::uint64_t without_key_ = 0, dropped_ = 0;
  std::function<void()> on_first_sample_;
  bool has_samples_ = false;
  std::set<Guid> writers_;  ///< that matched the reader
  /// Changes on their way to the disk.
  struct Unstored {
    std::uint64_t number;  ///< see DurableStore::append
    Guid writer;
    SequenceNumber change;
  };
  std::deque<Unstored> unstored_;
};

}  // namespace ddssec::rtps
