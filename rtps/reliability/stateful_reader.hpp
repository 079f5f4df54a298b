// The reader's side of the protocol: what has come, what is missing, what is asked for
// (RTPS 8.4.12).
#pragma once

#include <functional>
#include <map>

#include "rtps/reliability/reader_messages.hpp"
#include "rtps/reliability/stateful_writer.hpp"
#include "rtps/reliability/writer_proxy.hpp"
#include "wire/gap.hpp"

namespace ddssec::rtps {

/// Delivers each writer's changes in order, each once. Bounded: changes that came too early and
/// samples of which fragments are missing are kept up to the limits below. Beyond them the
/// identity with most of them loses its latest, which are requested again. No clock, no lock.
class StatefulReader final : private Timed {
 public:
  static constexpr std::uint32_t kLargestSample = 64u << 20;
  /// For readers whose samples are small.
  struct Limits {
    std::uint32_t largest_sample = kLargestSample;  ///< in fragments; larger ones are given up
    std::size_t held_octets = HeldOctets::kMax;
    std::size_t held_octets_of_one = HeldOctets::kMaxOfOne;
  };

  /// Takes the change, or refuses it for now (a full history): then it is kept here, and offered
  /// again with the writer's next heartbeat. A best-effort change that is refused is lost.
  using Deliver = std::function<bool(Change&)>;
  /// Without timers the owner calls tick whenever next_tick says so.
  StatefulReader(const Guid& guid, bool reliable, MessageSender& sender, Deliver deliver,
                 TimerQueue* timers = nullptr);
  ~StatefulReader() override;

  void limit(const Limits& limits);
  /// Told how many changes of a writer were given up that were not declared irrelevant
  /// (SAMPLE_LOST of DDS 1.4, 2.2.4.1).
  using Lost = std::function<void(std::int64_t count)>;
  void on_lost(Lost lost) { common_.lost = std::move(lost); }
  /// Says of a writer the first change that was taken and must not be acknowledged yet; `next`, if
  /// there is none before it.
  using Unfinished = std::function<SequenceNumber(const Guid& writer, SequenceNumber next)>;
  void acknowledge_before(Unfinished unfinished) { unfinished_ = std::move(unfinished); }
  /// After there is less unfinished: tells the writers that were heard.
  void acknowledge_again();
  /// Told of a sample that was given up because it is larger than the limit.
  using Dropped = std::function<void(const Guid& writer, std::uint32_t octets)>;
  void on_dropped(Dropped dropped) { dropped_ = std::move(dropped); }
  /// Told that a writer has nothing undelivered up to that group sequence number.
  using Group = std::function<void(const Guid& writer, SequenceNumber group)>;
  void on_group(Group group) { on_group_ = std::move(group); }
  /// Told of each sign of life of a writer of this process.
  using Alive = std::function<void(const Guid& writer)>;
  void on_alive(Alive alive) { alive_ = std::move(alive); }

  const Guid& guid() const { return guid_; }
  std::size_t matched() const { return writers_.size(); }
  bool is_matched(const Guid& writer) const { return writers_.contains(writer); }

  /// A writer that comes back with the keys that it left with goes on where it was: what it sent
  /// before that is not new, from any sender. `wants_history`: it may say that it starts
  /// anew with what it holds, but by a heartbeat that was not heard before.
  void match(MatchedWriter writer, MonotonicTime now, bool wants_history = false);
  /// `keys`: with what it is remembered, if at all.
  void unmatch(const Guid& writer, const std::optional<Sha256Digest>& keys = {});

  // Each returns whether it was new: only that is a sign of life. Old messages can be repeated.
  bool on_data(const GuidPrefix& from, const Data& data, const std::optional<Time>& time);
  bool on_data_frag(const GuidPrefix& from, const DataFrag& frag, const std::optional<Time>& time);
  bool on_heartbeat(const GuidPrefix& from, const Heartbeat& heartbeat);
  bool on_gap(const GuidPrefix& from, const Gap& gap);

  // Called by a writer of this process (see StatefulWriter::attach).
  /// False: it is not matched.
  bool attach(StatefulWriter& writer);
  void detach(const Guid& writer);
  /// False: refused for now.
  bool offer(const Change& change);
  void pass(const Guid& writer, SequenceNumber group) {
    if (on_group_) on_group_(writer, group);
  }
  /// Everything below `next` was offered, or will never be.
  void skip(const Guid& writer, SequenceNumber next);
  void hear(const Guid& writer) {
    if (alive_) alive_(writer);
  }

  /// There is room again: what was refused for now is offered again, and acknowledged if taken.
  void offer_again();
  /// True once everything has come that the matched reliable writers held when they were first
  /// heard.
  bool has_history() const;
  /// Asks writers that have not been heard yet.
  void tick(MonotonicTime now);
  MonotonicTime next_tick() const;

 private:
  void on_time(MonotonicTime now) override { tick(now); }
  WriterProxy* find(const Guid& writer) {
    const auto at = writers_.find(writer);
    return at == writers_.end() ? nullptr : &at->second;
  }
  bool accept(WriterProxy& proxy, SequenceNumber number, std::optional<Change> change);
  /// False: the fragment is of no sample that has room.
  bool has_place(WriterProxy& proxy, const DataFrag& frag, const std::optional<Time>& time);
  /// The identity that holds most gives up the latest of its writer that holds most: they are
  /// requested again.
  void trim();
  /// "What is there?", and when to ask again.
  void ask(WriterProxy& proxy, MonotonicTime now);
  /// What has come, and what is missing up to `last`.
  void acknowledge(WriterProxy& proxy, SequenceNumber last);

  const Guid guid_;
  const bool reliable_;
  MessageSender& sender_;
  ReaderMessages messages_;
  Dropped dropped_;
  Unfinished unfinished_;
  Alive alive_;
  Group on_group_;
  std::uint32_t largest_sample_ = kLargestSample;
  WriterProxy::Common common_;
  std::map<Guid, WriterProxy> writers_;
  PastWriters past_;
};

}  // namespace ddssec::rtps
