// The reader's side of the protocol: what has arrived, what is missing and what is requested (RTPS
// 8.4.12).
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
/// identity with the most loses its latest ones, which are requested again. No clock or lock.
class StatefulReader final : private Timed {
 public:
  static constexpr std::uint32_t kMaxSample = 64u << 20;
  /// Limits, which can be lowered for readers whose samples are small.
  struct Limits {
    /// Limit for samples in fragments; larger ones are given up.
    std::uint32_t largest_sample = kMaxSample;
    std::size_t held_octets = HeldOctets::kMax;
    std::size_t held_octets_of_one = HeldOctets::kMaxOfOne;
  };

  /// Takes the change, or refuses it for now (a full history): then it is kept here, and offered
  /// again with the writer's next HEARTBEAT. A best-effort change that is refused is lost.
  using Deliver = std::function<bool(Change&)>;
  /// Without timers, the owner must call tick at the time that next_tick returns.
  StatefulReader(const Guid& guid, bool reliable, MessageSender& sender, Deliver deliver,
                 TimerQueue* timers = nullptr);
  ~StatefulReader() override;

  void limit(const Limits& limits);
  /// What is held counts together with that of other readers, within the limits of `held`. Must be
  /// called before a writer is matched.
  void share_held(std::shared_ptr<HeldOctets> held);
  /// Called with the number of a writer's changes that were given up although they were not
  /// declared irrelevant (SAMPLE_LOST of DDS 1.4, 2.2.4.1).
  using Lost = std::function<void(std::int64_t count)>;
  void on_lost(Lost lost) { common_.lost = std::move(lost); }
  /// Returns the first change of a writer that was taken and must not be acknowledged yet, or
  /// `next` if there is none before it.
  using Unfinished = std::function<SequenceNumber(const Guid& writer, SequenceNumber next)>;
  void acknowledge_before(Unfinished unfinished) { unfinished_ = std::move(unfinished); }
  /// Must be called when fewer changes of a writer are unfinished: acknowledges to it.
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
  /// nullptr: it is not matched.
  const WriterProxy* writer(const Guid& guid) const {
    const auto at = writers_.find(guid);
    return at == writers_.end() ? nullptr : &at->second;
  }

  /// A writer that returns with the keys that it left with continues at its former position: what
  /// it sent before that is not new, from any sender. `wants_history`: the writer may start again
  /// with what it holds, but only by a HEARTBEAT that was not received before.
  void match(MatchedWriter writer, MonotonicTime now, bool wants_history = false);
  /// `keys`: the keys with which the writer is remembered; empty: it is not.
  void unmatch(const Guid& writer, const std::optional<Sha256Digest>& keys = {});

  /// From now on a matched writer of another process is sent to at these locators.
  void readdress(const Guid& writer, const LocatorList& locators);

  // All return whether the message was new. Only a new message is a sign of life, because old
  // messages can be repeated.
  /// `elsewhere`: a payload that is not in the submessage; empty: it is there.
  bool on_data(const GuidPrefix& from, const Data& data, const std::optional<Time>& time,
               Payload elsewhere = {});
  bool on_data_frag(const GuidPrefix& from, const DataFrag& frag, const std::optional<Time>& time);
  /// `is_protected`: by keys of the writer's participant.
  bool on_heartbeat(const GuidPrefix& from, const Heartbeat& heartbeat, bool is_protected = true);
  bool on_gap(const GuidPrefix& from, const Gap& gap);

  // Called by a writer of this process (see StatefulWriter::attach):
  /// Returns false if the writer is not matched.
  bool attach(StatefulWriter& writer);
  void detach(const Guid& writer);
  /// Returns false if the change is refused for now.
  bool offer(const Change& change);
  void pass(const Guid& writer, SequenceNumber group) {
    if (on_group_) on_group_(writer, group);
  }
  /// Everything below `next` was offered, or will never be.
  void skip(const Guid& writer, SequenceNumber next);
  void hear(const Guid& writer) {
    if (alive_) alive_(writer);
  }

  /// There is room again: offers what was refused for now, and acknowledges it if it is taken.
  void offer_again();
  /// Requests again what was refused for now: that writer may have replaced it. Returns the octets
  /// of the samples that will be sent again if it has not.
  std::size_t request_refused(const Guid& writer);
  struct Refused {
    std::uint64_t waiting = 0;    ///< changes that wait behind one that was refused for now
    std::uint64_t abandoned = 0;  ///< that waited when their writers left; never reset
  };
  /// A writer that comes back offers again what was abandoned.
  Refused refused() const;
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
  bool accept(WriterProxy& proxy, SequenceNumber number, std::optional<Change> change);
  /// Returns false if the fragment belongs to a sample that has no room.
  bool has_place(WriterProxy& proxy, const DataFrag& frag, const std::optional<Time>& time);
  /// Gives up the latest changes of the identity that holds the most, from its writer that holds
  /// the most. They are requested again.
  /// After something of this writer was held.
  void trim(const WriterProxy& proxy);
  void give_up_largest(const GuidPrefix& identity);
  /// Asks the writer what it holds, and schedules the next query.
  void ask(WriterProxy& proxy, MonotonicTime now);
  /// Acknowledges what has arrived, and requests what is missing up to `last`.
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
  bool shares_held_ = false;  ///< with other readers
  WriterProxy::Common common_;
  std::map<Guid, WriterProxy> writers_;
  PastWriters past_;
  std::uint64_t abandoned_ = 0;
};

}  // namespace ddssec::rtps
