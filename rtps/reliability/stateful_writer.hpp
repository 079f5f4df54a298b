// The writer's side of the protocol: who has what, who asks for what (RTPS 8.4.9).
#pragma once

#include <functional>
#include <map>
#include <set>
#include <vector>

#include "rtps/qos/qos.hpp"
#include "rtps/reliability/change_filter.hpp"
#include "rtps/reliability/key_payload.hpp"
#include "rtps/reliability/locator_counts.hpp"
#include "rtps/reliability/message_sender.hpp"
#include "rtps/reliability/repair_allowance.hpp"
#include "rtps/reliability/timer_queue.hpp"
#include "rtps/reliability/writer_history.hpp"
#include "wire/acknack.hpp"
#include "wire/entity_ids.hpp"
#include "wire/gap.hpp"
#include "wire/heartbeat.hpp"
#include "wire/locator.hpp"
#include "wire/nack_frag.hpp"

namespace ddssec::rtps {

/// A reader that matched a local writer.
struct MatchedReader {
  Guid guid;
  bool reliable = false;
  bool wants_history = false;  ///< transient-local or more
  LocatorList locators = {};   ///< empty if it is fed in this process
  bool in_process = false;
  std::shared_ptr<ChangeFilter> filter = {};  ///< nullptr: it gets everything
  KeyReading keys = {};
};

class StatefulReader;

/// What the writers of one publisher with GROUP access have in common.
struct WriterGroup {
  SequenceNumber current;  ///< group sequence number that was given last; 0 none
  GroupDigest writers = {};
};

/// No I/O but through the sender, no clock, no lock: the caller brings all three.
class StatefulWriter final : private Timed {
 public:
  /// Content filters that it applies; further readers get everything, and filter themselves.
  static constexpr std::size_t kMostFilters = 32;

  /// Without timers somebody calls tick whenever next_tick says so.
  StatefulWriter(const Guid& guid, const Qos& qos, MessageSender& sender,
                 TimerQueue* timers = nullptr);
  ~StatefulWriter() override;

  const Guid& guid() const { return guid_; }
  const Qos& qos() const { return qos_; }
  const WriterHistory& history() const { return history_; }
  std::size_t matched() const { return readers_.size(); }
  bool is_matched(const Guid& reader) const { return readers_.contains(reader); }

  /// A reliable reader is told at once what there is.
  void match(MatchedReader reader, MonotonicTime now);
  /// Readers that match from now on get what is held then, and nothing later.
  void serve_history_only() { history_only_ = true; }
  void unmatch(const Guid& reader);
  /// For readers that read keys of its type in one layout only.
  void rewrite_keys_with(KeyRewriter to_bare) { to_bare_key_ = std::move(to_bare); }
  /// Another filter of a matched reader, for what is sent from now on.
  void set_filter(const Guid& reader, std::shared_ptr<ChangeFilter> filter);

  /// True while so much is unacknowledged that more would only be lost: a writer in a hurry should
  /// wait a moment. Never true for transient-local writers, which keep what is acknowledged too.
  bool is_ahead() const;
  bool has_room(std::size_t payload_size, const KeyHash& instance = {}) const {
    return history_.has_room(payload_size, instance);
  }
  /// Stores and sends to all matched readers. The caller asked has_room before. Small samples of a
  /// writer in a hurry wait up to kLinger for more, if the sender may linger.
  SequenceNumber write(Change change, MonotonicTime now);
  static constexpr MonotonicTime kLinger = std::chrono::microseconds(100);
  /// LATENCY_BUDGET: small samples wait that long for more, but no longer than this.
  static constexpr MonotonicTime kMostBudget = std::chrono::milliseconds(100);
  /// Takes LATENCY_BUDGET and TRANSPORT_PRIORITY; 0 to 63 is the DSCP of what is sent.
  void hurry_as(const Qos& qos);
  /// Readers answer heartbeats that ask for it, not each sample: for whoever waits for them now.
  /// `even_if_none_is_missing`: to hear whether the readers still answer.
  void ask_for_acknowledgments(bool even_if_none_is_missing = false);

  /// Nobody gets this change any more (LIFESPAN); who asks for it is told that it is gone.
  void discard(SequenceNumber number) { history_.discard(number); }
  /// Tells all readers that the writer lives, without a sample (LIVELINESS MANUAL_BY_TOPIC).
  void assert_liveliness();

  /// False: it was said before, or says nothing yet (a pre-emptive one).
  bool on_acknack(const GuidPrefix& from, const AckNack& acknack, MonotonicTime now);
  bool on_nack_frag(const GuidPrefix& from, const NackFrag& nack, MonotonicTime now);
  /// Heartbeats that are due.
  void tick(MonotonicTime now);
  MonotonicTime next_tick() const;
  /// `f` whenever a reader of this process took what it had refused, or ended.
  void on_acknowledged(std::function<void()> f) { on_acknowledged_ = std::move(f); }
  /// Both must be matched with in_process; then the reader is fed directly until either unmatches
  /// or ends. Whoever matches second calls this.
  void attach(StatefulReader& reader);
  /// Its heartbeats and gaps tell where it stands in the group, which outlives it.
  void join(const WriterGroup& group) { group_ = &group; }
  /// While held back nothing is sent; then all of it (suspend_publications).
  void hold_back(bool held_back, MonotonicTime now);
  /// The reader does not want to be fed any more.
  void detach(const Guid& reader);
  /// The reader ends.
  void lose(const Guid& reader);
  /// A reader that refused something has room again.
  void feed(const Guid& reader);

  /// True if every reliable reader has everything.
  bool all_acknowledged() const;

 private:
  /// Fragments that a reader asked for and gets in portions.
  struct Repair {
    SequenceNumber sample;
    FragmentNumberSet missing;
    FragmentNumber next;
    MonotonicTime begun{};
    MonotonicTime due = kNever;  ///< the next portion; nothing is left: never
  };
  struct ReaderProxy {
    MatchedReader reader;
    SequenceNumber first_relevant;  ///< what a late joiner does not get lies below
    SequenceNumber acknowledged;    ///< everything up to here has arrived; see note_acknowledged
    std::optional<std::multiset<SequenceNumber>::iterator> lowest = {};  ///< in acknowledged_
    std::int32_t last_count = 0;
    std::int32_t last_frag_count = 0;
    SequenceNumber last_answered;  ///< base of the request that was answered last, and when
    MonotonicTime last_answer{};
    RepairAllowance allowance;
    Repair repair;
    StatefulReader* local = nullptr;
    bool wanted = true;  ///< the last change passed its filter
    /// It was not told yet that from here on nothing passed its filter; or 0.
    SequenceNumber filtered_from = {};
    SequenceNumber until = {};  ///< it gets nothing from here on; 0: everything
    bool accepts(const Change& change) const {
      return is_for(change) && filtered(change).value_or(true);
    }
    bool is_filtered() const { return reader.filter != nullptr || until.value != 0; }
    bool is_for(const Change& change) const {
      return until.value == 0 || change.sequence_number < until;
    }
    /// What its filter says; nothing: it has none, or the reader must judge itself.
    std::optional<bool> filtered(const Change& change) const {
      if (!reader.filter || !change.is_alive()) return std::nullopt;
      return reader.filter->passes(change);
    }
  };

  void on_time(MonotonicTime now) override { tick(now); }
  void heartbeat_at(MonotonicTime when);
  Destination to(const ReaderProxy& proxy) const {
    return {proxy.reader.guid.prefix, proxy.reader.locators, dscp_};
  }
  Destination to_all() const {
    return is_pairwise() ? to(readers_.begin()->second) : Destination{{}, locators_.all(), dscp_};
  }
  EntityId all_readers() const {
    return is_pairwise() ? readers_.begin()->first.entity : kEntityIdUnknown;
  }
  /// Its reader is the only one, and what it gets is protected by the key of that pair.
  bool is_pairwise() const {
    return guid_.entity == kVolatileMessageWriter && readers_.size() == 1;
  }
  ReaderProxy* find(const Guid& reader) {
    const auto at = readers_.find(reader);
    return at == readers_.end() ? nullptr : &at->second;
  }
  /// Of a matched reader, which comes or goes.
  void count(const ReaderProxy& proxy, int by);
  void note_acknowledged(ReaderProxy& proxy, SequenceNumber through);
  std::optional<GroupState> group_state() const;
  Gap gap_of(const EntityId& reader, SequenceNumber first, SequenceNumber end) const;
  void feed(ReaderProxy& proxy);
  void send_change(const Destination& to, const EntityId& reader, const Change& change,
                   std::uint32_t most_fragments = ~0u);
  /// What of a change is sent.
  BytesView payload_of(const Change& change);
  void send_filtered(const Change& change);
  bool filter(const Change& change);
  void send_filtered_gap(ReaderProxy& proxy, SequenceNumber next);
  /// Before a heartbeat that would make readers ask for what they must not get.
  void send_filtered_gaps();
  void send_fragment(const Destination& to, const EntityId& reader, const Change& change,
                     FragmentNumber number);
  void send_heartbeat(const Destination& to, const EntityId& reader, SequenceNumber first,
                      bool is_final, bool asserts_liveliness = false);
  bool wants_acknowledgments(std::size_t written, const KeyHash& instance);
  bool is_hurried(MonotonicTime now);
  void continue_repair(ReaderProxy& proxy, MonotonicTime now);
  void be_attentive(MonotonicTime now);
  bool answer_requests(ReaderProxy& proxy, const SequenceNumberSet& missing, MonotonicTime now);
  void schedule_heartbeat(MonotonicTime now);
  void release_acknowledged();

  const Guid guid_;
  const Qos qos_;
  MessageSender& sender_;
  WriterHistory history_;
  std::map<Guid, ReaderProxy> readers_;
  /// Of the reliable ones, so that nobody looks for the lowest.
  std::multiset<SequenceNumber> acknowledged_;
  LocatorCounts locators_;
  std::function<void()> on_acknowledged_;
  const WriterGroup* group_ = nullptr;
  bool held_back_ = false;
  SequenceNumber held_from_;  ///< the first that was not sent
  bool history_only_ = false;
  std::size_t bare_only_ = 0, short_is_hash_ = 0;  ///< matched readers with that KeyReading
  KeyRewriter to_bare_key_;
  Bytes key_scratch_;
  std::size_t filters_ = 0;      ///< readers that do not get everything
  LocatorList wanted_locators_;  ///< of whoever wanted the last change
  std::vector<FilterResult> filter_results_;
  std::int32_t heartbeat_count_ = 0;
  MonotonicTime next_heartbeat_ = kNever;
  MonotonicTime period_{};
  int unanswered_ = 0;  ///< heartbeats since a reader was heard
  const int samples_per_question_;
  MonotonicTime budget_{};
  std::uint8_t dscp_ = 0;
  int written_since_question_ = 0;  ///< a question: a heartbeat that wants an answer
  std::size_t octets_since_question_ = 0;
  MonotonicTime last_heartbeat_{std::chrono::hours(-1)};
  MonotonicTime last_write_{};
  std::uint32_t samples_heard_ = 0;  ///< by the participant, when last_write_ was
  int quick_writes_ = 0;             ///< in a row
};

}  // namespace ddssec::rtps
