// The reader's side of the protocol: the changes that have arrived, are missing or are requested
// (RTPS 8.4.12).
#pragma once

#include <functional>
#include <map>

#include "rtps/reliability/reader_messages.hpp"
#include "rtps/reliability/stateful_writer.hpp"
#include "rtps/reliability/writer_proxy.hpp"
#include "wire/gap.hpp"

namespace ddssec::rtps {

/// Delivers each writer's changes in order, each once. Its memory is limited: changes that arrived
/// early and samples with missing fragments are kept up to the limits below. Above them, the
/// identity that holds the most loses its latest ones, which are requested again. No clock or lock.
class StatefulReader final : private TimedObject, private HeldOctets::Holder {
 public:
  static constexpr std::uint32_t kMaxSample = 64u << 20;
  /// Limits, which can be lowered for readers whose samples are small.
  struct Limits {
    /// The limit for samples in fragments. Larger ones are given up.
    std::uint32_t largest_sample = kMaxSample;
    std::size_t held_octets = HeldOctets::kMax;
    std::size_t held_octets_of_one = HeldOctets::kMaxOfOne;
  };

  /// Takes the change, or returns false to refuse it for now (a full history). A refused change is
  /// kept here, and offered again with the writer's next HEARTBEAT. If it is a best-effort change,
  /// it is lost.
  using Deliver = std::function<bool(Change&)>;
  /// Without timers, the owner must call tick at the time that next_tick returns.
  StatefulReader(const Guid& guid, bool reliable, MessageSender& sender, Deliver deliver,
                 TimerQueue* timers = nullptr);
  ~StatefulReader() override;

  void limit(const Limits& limits);
  /// Makes the octets that are held count together with those of other readers, within the limits
  /// of `held`. Call it before a writer is matched.
  void share_held(std::shared_ptr<HeldOctets> held);
  /// Called with the number of a writer's changes that were given up although they were not
  /// declared irrelevant (SAMPLE_LOST of DDS 1.4, 2.2.4.1).
  using Lost = std::function<void(std::int64_t count)>;
  void on_lost(Lost lost) { common_.lost = std::move(lost); }
  /// Returns the first change of a writer that was taken and must not be acknowledged yet, or
  /// `next` if there is none before it.
  using Unfinished = std::function<SequenceNumber(const Guid& writer, SequenceNumber next)>;
  void acknowledge_before(Unfinished unfinished) { unfinished_ = std::move(unfinished); }
  /// Acknowledges to the writer. Call it when fewer of its changes are unfinished.
  void acknowledge_again(const Guid& writer);
  /// Called for a sample that was given up because it is larger than the limit.
  using Dropped = std::function<void(const Guid& writer, std::uint32_t octets)>;
  void on_dropped(Dropped dropped) { dropped_ = std::move(dropped); }
  /// Called when a writer has delivered everything up to that group sequence number.
  using Group = std::function<void(const Guid& writer, SequenceNumber group)>;
  void on_group(Group group) { on_group_ = std::move(group); }
  /// Called for each sign of life of a writer of this process.
  using Alive = std::function<void(const Guid& writer)>;
  void on_alive(Alive alive) { alive_ = std::move(alive); }

  const Guid& guid() const { return guid_; }
  std::size_t matched() const { return writers_.size(); }
  /// Returns nullptr if the writer is not matched.
  const WriterProxy* writer(const Guid& guid) const {
    const auto at = writers_.find(guid);
    return at == writers_.end() ? nullptr : &at->second;
  }

  /// Matches a writer. A writer that returns with the keys that it had when it left continues at
  /// its former position: what it sent before that is not new, from any sender. With
  /// `wants_history`, the writer may start again with the changes that it holds, but only by a
  /// HEARTBEAT that was not received before.
  void match(MatchedWriter writer, MonotonicTime now, bool wants_history = false);
  /// Removes the writer. It is remembered with `keys`; if they are empty, it is not.
  void unmatch(const Guid& writer, const std::optional<Sha256Digest>& keys = {});

  /// Call it when the keys of the writer have changed; without an entity, those of all writers of
  /// the participant. See WriterProxy and PastWriters. When former keys have ended, reliable
  /// writers are asked for a HEARTBEAT.
  void note_key_change(const Guid& writer, KeyChange change, MonotonicTime now,
                       const PastWriters::KeysOf& keys_of);
  /// Sets the locators to which messages for a matched writer of another process are sent.
  void readdress(const Guid& writer, const LocatorList& locators);

  // Only a new message is a sign of life, because old messages can be repeated.
  /// Handles a DATA. Returns true if it was new. `elsewhere` is a payload that is not in the
  /// submessage; empty if the submessage has it. `age` is that of the keys that protect it, here
  /// and below.
  bool on_data(const GuidPrefix& from, const Data& data, const std::optional<Time>& time,
               Payload elsewhere, KeyAge age);
  /// Handles a DATA_FRAG. Returns true if it was new. `is_marked` means that only the payload is
  /// proven, and that it has the mark of its change (end_mark).
  bool on_data_frag(const GuidPrefix& from, const DataFrag& frag, const std::optional<Time>& time,
                    bool is_marked, KeyAge age);
  /// Handles a HEARTBEAT. Returns true if it was new. `is_protected` means that keys of the
  /// writer's participant protect the message.
  bool on_heartbeat(const GuidPrefix& from, const Heartbeat& heartbeat, bool is_protected,
                    KeyAge age);
  /// Handles a GAP. Returns true if it was new.
  bool on_gap(const GuidPrefix& from, const Gap& gap, KeyAge age);

  // Called by a writer of this process (see StatefulWriter::attach):
  /// Returns false if the writer is not matched.
  bool attach(StatefulWriter& writer);
  void detach(const Guid& writer);
  /// Offers a change. Returns false if it is refused for now.
  bool offer(const Change& change);
  void pass(const Guid& writer, SequenceNumber group) {
    if (on_group_) on_group_(writer, group);
  }
  /// Skips everything below `next`, which was offered or will never be.
  void skip(const Guid& writer, SequenceNumber next);
  void hear(const Guid& writer) {
    if (alive_) alive_(writer);
  }

  /// Offers changes that were refused for now, and acknowledges them if they are taken. Call it
  /// when there is room again.
  void offer_again();
  /// Requests again what was refused for now, because that writer may have replaced it. Returns the
  /// octets of the samples that will be sent again if it has not.
  std::size_t request_refused(const Guid& writer);
  struct RefusedCounts {
    std::uint64_t waiting = 0;    ///< changes that wait behind one that was refused for now
    std::uint64_t abandoned = 0;  ///< changes that waited when their writers left; never reset
  };
  /// Returns the numbers of refused changes. A writer that comes back offers again what was
  /// abandoned.
  RefusedCounts refused() const;
  /// True once everything has arrived that the matched reliable writers held when they were first
  /// heard.
  bool has_history() const;
  /// Queries writers that have not been heard yet.
  void tick(MonotonicTime now);
  MonotonicTime next_tick() const;

 private:
  void on_time(MonotonicTime now) override { tick(now); }
  WriterProxy* find(const Guid& writer) {
    const auto at = writers_.find(writer);
    return at == writers_.end() ? nullptr : &at->second;
  }
  bool accept(WriterProxy& proxy, SequenceNumber number, std::optional<Change> change, KeyAge age);
  /// Begins a sample if needed. Returns false if the fragment belongs to a sample that has no room.
  bool has_place(WriterProxy& proxy, const DataFrag& frag, const std::optional<Time>& time,
                 KeyAge age);
  /// Gives up the latest change of the writer that holds the most.
  void give_up_latest(const GuidPrefix& identity) override;
  /// Asks the writer what it holds, and schedules the next query.
  void send_query(WriterProxy& proxy, MonotonicTime now);
  /// Acknowledges the changes that have arrived, and requests those that are missing up to `last`.
  void acknowledge(WriterProxy& proxy, SequenceNumber last);

  const Guid guid_;
  const bool is_reliable_;
  MessageSender& sender_;
  ReaderMessages messages_;
  Dropped dropped_;
  Unfinished unfinished_;
  Alive alive_;
  Group on_group_;
  std::uint32_t largest_sample_ = kMaxSample;
  WriterProxy::Common common_;
  std::map<Guid, WriterProxy> writers_;
  PastWriters past_;
  std::uint64_t abandoned_ = 0;
};

}  // namespace ddssec::rtps
