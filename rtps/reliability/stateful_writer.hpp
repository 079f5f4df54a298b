// The writer's side of the protocol: the changes that each reader has received and requests (RTPS
// 8.4.9).
#pragma once

#include <functional>

#include "rtps/reliability/filtered_writing.hpp"
#include "rtps/reliability/heartbeat_schedule.hpp"
#include "rtps/reliability/local_delivery.hpp"
#include "rtps/reliability/memory_writing.hpp"
#include "rtps/reliability/octet_allowance.hpp"
#include "rtps/reliability/retransmissions.hpp"
#include "rtps/reliability/timer_queue.hpp"
#include "rtps/reliability/write_pace.hpp"
#include "wire/acknack.hpp"

namespace ddssec::rtps {

/// Sends only through the sender. No clock or lock: the caller passes times and serializes calls.
class StatefulWriter final : private TimedObject {
 public:
  /// The largest number of content filters that the writer applies. Further readers get everything
  /// and filter themselves.
  static constexpr std::size_t kMaxFilters = 32;

  /// Without timers, the owner must call tick at the time that next_tick returns.
  StatefulWriter(const Guid& guid, const Qos& qos, MessageSender& sender,
                 TimerQueue* timers = nullptr);
  ~StatefulWriter() override;

  const Guid& guid() const { return guid_; }
  const Qos& qos() const { return qos_; }
  const WriterHistory& history() const { return history_; }
  const MatchedReaders& readers() const { return readers_; }

  /// Matches a reader. A reliable one is sent a HEARTBEAT at once.
  void match(MatchedReader reader, MonotonicTime now);
  /// Makes readers that match from now on get the changes that are held when they match, and
  /// nothing later.
  void serve_history_only() { is_history_only_ = true; }
  void unmatch(const Guid& reader);
  /// Sets the locators to which messages for a matched reader of another process are sent.
  void readdress(const Guid& reader, const LocatorList& locators, MonotonicTime now);
  /// Sets the function for readers that can read keys of its type only in one layout.
  void rewrite_keys_with(KeyRewriter to_bare) { messages_.rewrite_keys_with(std::move(to_bare)); }
  /// Changes the filter of a matched reader, for what is sent from now on.
  void set_filter(const Guid& reader, std::shared_ptr<ChangeFilter> filter);

  /// True while so much is unacknowledged that further samples would only be lost: a fast writer
  /// should wait briefly. Only readers that acknowledge in time count (Timeliness), so that a
  /// reader that is gone, slow or hostile does not delay the writer. Never true for TRANSIENT_LOCAL
  /// writers, which also keep what is acknowledged.
  bool is_ahead(MonotonicTime now);
  /// Stores the change and sends it to all matched readers. The caller must have checked that
  /// history() has room.
  /// Small samples may wait for more (see WritePace), if the sender allows it.
  SequenceNumber write(Change change, MonotonicTime now);
  /// Applies LATENCY_BUDGET and TRANSPORT_PRIORITY; a priority of 0 to 63 is the DSCP of messages.
  void set_urgency(const Qos& qos);
  /// Requests acknowledgments for a caller that waits for them: readers do not acknowledge each
  /// sample, but answer such HEARTBEATs. With `even_if_none_is_missing`, also checks whether the
  /// readers still answer.
  void request_acknowledgments(bool even_if_none_is_missing = false);

  /// Requests an acknowledgment of one reader, even if it misses nothing or does not match.
  void request_acknack(const Guid& reader, const LocatorList& at);

  /// Drops a change, which no reader gets any more (LIFESPAN). A request for it is answered with a
  /// GAP.
  void discard(SequenceNumber number) { history_.discard(number); }
  /// Asserts the writer's liveliness to all readers without a sample (LIVELINESS MANUAL_BY_TOPIC).
  void assert_liveliness();

  /// Call it when the keys of the reader have changed; without an entity, those of all readers of
  /// the participant. When former keys have ended, the counts of readers go on from those under the
  /// newest ones.
  void note_key_change(const Guid& reader, KeyChange change);
  /// Both return false if the message was received before, or contains nothing yet (a pre-emptive
  /// one). `is_protected` means that keys of its sender protect it; `age` is theirs.
  bool on_acknack(const GuidPrefix& from, const AckNack& acknack, MonotonicTime now,
                  bool is_protected, KeyAge age);
  bool on_nack_frag(const GuidPrefix& from, const NackFrag& nack, MonotonicTime now,
                    bool is_protected, KeyAge age);
  /// Sends the HEARTBEATs that are due.
  void tick(MonotonicTime now);
  MonotonicTime next_tick() const;
  /// Calls `f` whenever a reader of this process took what it had refused, or was removed.
  void on_acknowledged(std::function<void()> f) { on_acknowledged_ = std::move(f); }
  /// Makes its HEARTBEATs and GAPs include its position in the group. `group` must outlive the
  /// writer.
  void join(const WriterGroup& group);
  /// From now on nothing is sent until `resume` (suspend_publications). Has no effect twice.
  void suspend();
  /// Sends what was written since `suspend`, and ends it.
  void resume(MonotonicTime now);
  /// True if every reliable reader has received everything.
  bool all_acknowledged() const { return readers_.acknowledged().reach(history_.last()); }

  /// Returns the memory for readers of other processes on this machine. Flushes the sender.
  MemoryWriting& memory();

  // Readers of this process (see LocalDelivery):
  /// Makes the reader get changes directly, until either side unmatches or is destroyed. Both must
  /// be matched with `is_in_process` set. The side that matches second calls this.
  void attach(StatefulReader& reader);
  /// Ends direct delivery, because the reader no longer wants it.
  void detach(const Guid& reader);
  /// Removes a reader that is being destroyed.
  void remove_local_reader(const Guid& reader);
  /// Offers changes again to a reader that refused one and has room again.
  void offer_to_local_reader(const Guid& reader);

 private:
  void on_time(MonotonicTime now) override { tick(now); }
  void send(const Change& written, MonotonicTime now);
  /// Sends the latest changes of the history, up to the octets that best-effort readers may get
  /// now.
  void send_history(ReaderProxy& proxy, MonotonicTime now);
  /// Sends a HEARTBEAT that requires an answer.
  void send_heartbeat_without_final(const Receiver& receiver, SequenceNumber first);
  void continue_repair(ReaderProxy& proxy, MonotonicTime now);
  void release_acknowledged();

  const Guid guid_;
  const Qos qos_;
  MessageSender& sender_;
  WriterHistory history_;
  WriterMessages messages_;
  MatchedReaders readers_;
  FilteredWriting filtered_;
  MemoryWriting memory_;
  EvaluationAllowance evaluations_;
  Retransmissions retransmissions_;
  LocalDelivery local_;
  HistoryAllowance history_allowance_;
  HeartbeatSchedule schedule_;
  PiggybackHeartbeats piggyback_;
  WritePace pace_;
  std::function<void()> on_acknowledged_;
  bool is_suspended_ = false;
  bool is_history_only_ = false;
  SequenceNumber suspended_from_;  ///< the first change that was not sent
};

}  // namespace ddssec::rtps
