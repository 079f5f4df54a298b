// The reader's side of the protocol: what has come, what is missing, what is asked for
// (RTPS 8.4.12).
#pragma once

#include <functional>
#include <map>

#include "base/hash.hpp"
#include "rtps/reliability/fragment_set.hpp"
#include "rtps/reliability/past_writers.hpp"
#include "rtps/reliability/stateful_writer.hpp"
#include "wire/data_frag.hpp"
#include "wire/gap.hpp"
#include "wire/heartbeat.hpp"

namespace ddssec::rtps {

/// A writer that matched a local reader.
struct MatchedWriter {
  Guid guid;
  bool reliable = false;
  LocatorList locators = {};  ///< empty if it feeds us in this process
  bool in_process = false;
  /// What its samples are protected with, if anything: nobody but the writer made those that come
  /// while it is the same, but anybody may have kept some of them.
  std::optional<Sha256Digest> keys = {};
  /// Whose share of the bounds it takes; nothing: its participant's.
  std::optional<GuidPrefix> identity = {};
  GuidPrefix owner() const { return identity.value_or(guid.prefix); }
};

/// Delivers each writer's changes in order, each once. Bounded: changes that came too early and
/// samples of which fragments are missing are kept up to the limits below. Beyond them the
/// identity with most of them loses its latest, which are requested again. No clock, no lock.
class StatefulReader final : private Timed {
 public:
  static constexpr std::size_t kMostEarlyChanges = 2048;
  static constexpr std::size_t kMostPartialSamples = 4;
  static constexpr std::uint32_t kLargestSample = 64u << 20;
  /// Samples of more fragments than that must have fragments of at least kLeastFragmentSize: the
  /// number of fragments is what a sample costs beside its octets.
  static constexpr std::uint32_t kMostSmallFragments = 4096;
  static constexpr std::uint16_t kLeastFragmentSize = 512;
  /// Of what is kept, of all writers, and of the writers of one identity.
  static constexpr std::size_t kMostHeldOctets = std::size_t{256} << 20;
  static constexpr std::size_t kMostHeldOctetsOfOne = kMostHeldOctets / 2;
  /// What each change that is kept counts beside its octets.
  static constexpr std::size_t kPricePerChange = 256;
  /// For readers whose samples are small.
  struct Limits {
    std::uint32_t largest_sample = kLargestSample;  ///< in fragments; larger ones are given up
    std::size_t held_octets = kMostHeldOctets;
    std::size_t held_octets_of_one = kMostHeldOctetsOfOne;
  };

  /// Takes the change, or refuses it for now (a full history): then it is kept here, and offered
  /// again with the writer's next heartbeat. A best-effort change that is refused is lost.
  using Deliver = std::function<bool(Change&)>;
  /// Without timers somebody calls tick whenever next_tick says so.
  StatefulReader(const Guid& guid, bool reliable, MessageSender& sender, Deliver deliver,
                 TimerQueue* timers = nullptr);
  ~StatefulReader() override;

  void limit(const Limits& limits) { limits_ = limits; }
  /// Told how many changes of a writer were given up that nobody declared irrelevant
  /// (SAMPLE_LOST of DDS 1.4, 2.2.4.1).
  using Lost = std::function<void(std::int64_t count)>;
  void on_lost(Lost lost) { lost_ = std::move(lost); }
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
  /// before that is not new, whoever sends it again. `wants_history`: it may say that it starts
  /// anew with what it holds, but by a heartbeat that was not heard before.
  void match(MatchedWriter writer, MonotonicTime now, bool wants_history = false);
  /// `keys`: with what it is remembered, if at all.
  void unmatch(const Guid& writer, const std::optional<Sha256Digest>& keys = {});

  // Each returns whether it was new: only that is a sign of life. Anybody can repeat what was said.
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
  struct Partial {
    Change change;
    std::uint16_t fragment_size = 0;
    FragmentSet have;
    std::size_t price = 0;
    SequenceNumber number() const { return change.sequence_number; }
  };
  struct Waiting {
    std::optional<Change> change;  ///< nothing: irrelevant
    std::size_t price = 0;
  };
  using Early = std::map<SequenceNumber, Waiting>;
  struct WriterProxy {
    MatchedWriter writer;
    SequenceNumber next{1};  ///< everything below was delivered or given up
    Early early;
    std::vector<Partial> partial;  ///< by their numbers
    std::size_t held = 0;          ///< the price of both
    std::int32_t last_heartbeat = 0;
    SequenceNumber announced;    ///< the last that a heartbeat spoke of
    SequenceNumber history_end;  ///< the same of its first heartbeat
    bool heard = false;          ///< a heartbeat of it came
    bool started = false;        ///< a change of it came, or a heartbeat said where it stands
    bool waits = false;          ///< for a heartbeat later than last_heartbeat, with all changes
    StatefulWriter* local = nullptr;
    MonotonicTime next_question = kNever;
    MonotonicTime question_period{};
    Destination destination() const { return {writer.guid.prefix, writer.locators}; }
  };

  struct Share {
    std::size_t writers = 0;
    std::size_t held = 0;
  };

  void on_time(MonotonicTime now) override { tick(now); }
  void resume(WriterProxy& proxy, bool wants_history);
  /// "What is there?", and when to ask again.
  void ask(WriterProxy& proxy, MonotonicTime now);
  WriterProxy* find(const Guid& writer) {
    const auto at = writers_.find(writer);
    return at == writers_.end() ? nullptr : &at->second;
  }
  bool accept(WriterProxy& proxy, SequenceNumber number, std::optional<Change> change);
  void advance(WriterProxy& proxy);
  void skip_to(WriterProxy& proxy, SequenceNumber number);
  void note_lost(WriterProxy& proxy, SequenceNumber until);
  static Partial* find_partial(WriterProxy& proxy, SequenceNumber number);
  void forget_partials(WriterProxy& proxy, SequenceNumber first, SequenceNumber last);
  Early::iterator forget_early(WriterProxy& proxy, Early::iterator at);
  void hold(WriterProxy& proxy, std::size_t price);
  void let_go(WriterProxy& proxy, std::size_t price);
  /// The identity that holds most gives up the latest of its writer that holds most: they are
  /// requested again.
  void trim();
  void forget_latest(WriterProxy& proxy);
  void forget_below(WriterProxy& proxy, SequenceNumber number);
  bool keep_early(WriterProxy& proxy, SequenceNumber number, std::optional<Change> change);
  Change change_of(const GuidPrefix& from, const Data& data, const std::optional<Time>& time) const;
  Partial* partial_of(WriterProxy& proxy, const DataFrag& frag, const std::optional<Time>& time);
  /// Samples or parts of them, up to `last`.
  static bool misses_any(const WriterProxy& proxy, SequenceNumber last);
  void acknowledge(WriterProxy& proxy, SequenceNumber last);
  void ask_for_fragments(WriterProxy& proxy, const Partial& partial);

  const Guid guid_;
  const bool reliable_;
  MessageSender& sender_;
  Deliver deliver_;
  Lost lost_;
  Dropped dropped_;
  Unfinished unfinished_;
  Alive alive_;
  Group on_group_;
  Limits limits_;
  SpareNodes<Early> spare_;
  std::map<Guid, WriterProxy> writers_;
  std::size_t held_ = 0;                ///< of all of them
  std::map<GuidPrefix, Share> shares_;  ///< by identity
  PastWriters past_;
  std::int32_t count_ = 0;  ///< of acknowledgements: whoever comes back hears later ones
};

}  // namespace ddssec::rtps
