// The writer's side of the protocol: who has what, who asks for what (RTPS 8.4.9).
#pragma once

#include <functional>

#include "rtps/reliability/filtered_writing.hpp"
#include "rtps/reliability/heartbeat_schedule.hpp"
#include "rtps/reliability/local_delivery.hpp"
#include "rtps/reliability/octet_allowance.hpp"
#include "rtps/reliability/retransmissions.hpp"
#include "rtps/reliability/timer_queue.hpp"
#include "rtps/reliability/write_pace.hpp"
#include "wire/acknack.hpp"

namespace ddssec::rtps {

/// No I/O but through the sender, no clock, no lock: the caller brings all three.
class StatefulWriter final : private Timed {
 public:
  /// Content filters that it applies; further readers get everything, and filter themselves.
  static constexpr std::size_t kMostFilters = 32;

  /// Without timers the owner calls tick whenever next_tick says so.
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
  void rewrite_keys_with(KeyRewriter to_bare) { messages_.rewrite_keys_with(std::move(to_bare)); }
  /// Another filter of a matched reader, for what is sent from now on.
  void set_filter(const Guid& reader, std::shared_ptr<ChangeFilter> filter);

  /// True while so much is unacknowledged that more would only be lost: a writer in a hurry should
  /// wait a moment. Never true for transient-local writers, which keep what is acknowledged too.
  bool is_ahead() const;
  bool has_room(std::size_t payload_size, const KeyHash& instance = {}) const {
    return history_.has_room(payload_size, instance);
  }
  /// Stores and sends to all matched readers. The caller asked has_room before. Small samples may
  /// wait for more (see WritePace), if the sender may linger.
  SequenceNumber write(Change change, MonotonicTime now);
  /// Takes LATENCY_BUDGET and TRANSPORT_PRIORITY; 0 to 63 is the DSCP of what is sent.
  void hurry_as(const Qos& qos);
  /// Readers answer heartbeats that ask for it, not each sample: for a caller that waits for them.
  /// `even_if_none_is_missing`: to hear whether the readers still answer.
  void ask_for_acknowledgments(bool even_if_none_is_missing = false);

  /// No reader gets this change any more (LIFESPAN); a request is answered that it is gone.
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
  /// Its heartbeats and gaps tell where it stands in the group, which outlives it.
  void join(const WriterGroup& group);
  /// While held back nothing is sent; then all of it (suspend_publications).
  void hold_back(bool held_back, MonotonicTime now);
  /// True if every reliable reader has everything.
  bool all_acknowledged() const { return readers_.acknowledged().reach(history_.last()); }

  // Readers of this process (see LocalDelivery).
  /// Both must be matched with in_process; then the reader is fed directly until either unmatches
  /// or ends. The side that matches second calls this.
  void attach(StatefulReader& reader);
  /// The reader does not want to be fed any more.
  void detach(const Guid& reader);
  /// The reader ends.
  void lose(const Guid& reader);
  /// A reader that refused something has room again.
  void feed(const Guid& reader);

 private:
  void on_time(MonotonicTime now) override { tick(now); }
  void send(const Change& written, MonotonicTime now);
  /// The latest of it, as much as best-effort readers may get now.
  void send_history(const ReaderProxy& proxy, MonotonicTime now);
  /// Which heartbeat rides on a change that was just written.
  PiggybackHeartbeats::Kind heartbeat_for(const Change& written, MonotonicTime now);
  /// A question wants an answer.
  void send_question(const Receiver& receiver, SequenceNumber first);
  void send_question(const ReaderProxy& proxy);
  void note_request(MonotonicTime now);
  void continue_repair(ReaderProxy& proxy, MonotonicTime now);
  void release_acknowledged();

  const Guid guid_;
  const Qos qos_;
  MessageSender& sender_;
  WriterHistory history_;
  WriterMessages messages_;
  MatchedReaders readers_;
  FilteredWriting filtered_;
  Retransmissions retransmissions_;
  LocalDelivery local_;
  HistoryAllowance history_allowance_;
  HeartbeatSchedule schedule_;
  PiggybackHeartbeats piggyback_;
  WritePace pace_;
  std::function<void()> on_acknowledged_;
  bool held_back_ = false;
  bool history_only_ = false;
  SequenceNumber held_from_;  ///< the first that was not sent
};

}  // namespace ddssec::rtps
