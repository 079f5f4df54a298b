// The state of a matched writer, as the reader knows it (WriterProxy of RTPS 8.4.10.4).
#pragma once

#include <functional>
#include <memory>

#include "base/hash.hpp"
#include "rtps/reliability/contradictions.hpp"
#include "rtps/reliability/early_changes.hpp"
#include "rtps/reliability/partial_samples.hpp"
#include "rtps/reliability/past_writers.hpp"
#include "rtps/reliability/query_timer.hpp"
#include "rtps/reliability/recent_messages.hpp"
#include "wire/heartbeat.hpp"
#include "wire/locator.hpp"

namespace ddssec::rtps {

class StatefulWriter;

/// A writer that matched a local reader.
struct MatchedWriter {
  Guid guid;
  bool is_reliable = false;
  LocatorList locators = {};  ///< empty if it delivers directly in this process
  bool is_in_process = false;
  /// The digest of the keys that protect its samples; empty if they are unprotected. While the keys
  /// are the same, only the writer can have created the samples that arrive, but an attacker may
  /// have kept some of them.
  std::optional<Sha256Digest> keys = {};
  /// The identity whose share of the limits it uses; if empty, that of its participant.
  std::optional<GuidPrefix> identity = {};
  /// True if the writer repeats the changes that it keeps only for a reader that begins with number
  /// 0.
  bool begins_at_zero = false;
  /// Called when messages in the writer's name contradict each other (Contradictions). If it is
  /// empty, contradictions are not looked for.
  std::function<void(const Guid& writer)> contradicted = {};
  GuidPrefix owner() const { return identity.value_or(guid.prefix); }
};

/// Delivers the writer's changes in order, each once. Changes that arrived early and samples with
/// missing fragments are kept until their turn. No I/O, clock or lock.
class WriterProxy {
 public:
  static constexpr std::size_t kMaxEarlyChanges = 2048;
  /// The limits for the changes that forget_refused() forgets at once: their number and their
  /// octets. One change is always forgotten.
  static constexpr std::size_t kMaxForgotten = 256, kMaxForgottenOctets = std::size_t{256} << 10;

  /// The objects that the proxies of one reader share. It must outlive them.
  struct Common {
    /// Takes the change, or returns false to refuse it for now.
    std::function<bool(Change&)> deliver = {};
    /// Called with the number of changes that were given up although the writer did not declare
    /// them irrelevant.
    std::function<void(std::int64_t count)> lost = {};
    std::shared_ptr<HeldOctets> held = std::make_shared<HeldOctets>();
    HeldOctets::Holder* holder = nullptr;  ///< the reader
    EarlyChanges::Spare spare = {};
  };

  /// If `reader_is_reliable` is false, a reliable writer is treated as a best-effort one.
  WriterProxy(MatchedWriter writer, bool reader_is_reliable, Common& common);
  WriterProxy(const WriterProxy&) = delete;
  WriterProxy& operator=(const WriterProxy&) = delete;

  const MatchedWriter& writer() const { return writer_; }
  void set_locators(LocatorList locators) { writer_.locators = std::move(locators); }
  /// True if missing changes are requested.
  bool is_reliable() const { return is_reliable_; }
  /// Returns the next number: every change below was delivered or given up.
  SequenceNumber next() const { return next_; }
  /// Returns the last change that a HEARTBEAT announced.
  SequenceNumber announced() const { return announced_; }
  /// True if everything that it has announced was delivered or given up.
  bool has_caught_up() const { return next_ > announced_; }
  /// True if a HEARTBEAT has arrived.
  bool was_heard() const { return was_heard_; }
  /// True once everything has arrived that a reliable writer held when it was first heard.
  bool has_history() const { return !is_reliable_ || (was_heard_ && next_ > history_end_); }

  /// Continues at the former position, because the writer was matched before. With `wants_history`,
  /// nothing is delivered until a HEARTBEAT arrives. If its count is later than before, the writer
  /// may start again with the changes that it holds.
  void resume(const PastWriters::Position& past, bool wants_history);
  PastWriters::Position position(const Sha256Digest& keys) const {
    return {keys,
            next_,
            heartbeats_.last(),
            std::min(newest_next_, next_),
            heartbeats_.last_newest(),
            is_doubted_};
  }

  /// True if the change was neither delivered nor given up, and is not held completely.
  bool lacks(SequenceNumber number) const { return number >= next_ && !early_.contains(number); }
  /// Takes a change with a number from next() on; an empty one means that the number is irrelevant.
  /// Returns false if it is already known, or if there is no room to keep it. `age` is that of the
  /// keys that protect it, here and below.
  bool accept(SequenceNumber number, std::optional<Change> change, KeyAge age);
  /// Returns false if the HEARTBEAT was received before. `is_protected` means that keys of the
  /// writer's participant protect it.
  bool on_heartbeat(const Heartbeat& heartbeat, bool is_protected, KeyAge age);
  /// Call it when keys of the writer have come that revise the former ones.
  void note_revised();
  /// Call it when former keys of the writer have ended. Others who had them may have sent in its
  /// name. Gives up what is held. The next HEARTBEAT, or with best effort the next change, decides
  /// where the writer is, but never before what came under the newest keys: older changes may be
  /// recordings.
  void distrust_former_keys();
  /// True while the next HEARTBEAT determines where the writer starts.
  bool waits_for_heartbeat() const { return waits_for_heartbeat_; }
  /// Delivers what is held below `number`, and gives up what is missing there.
  void skip_to(SequenceNumber number, KeyAge age);
  /// Forgets the next change if it was refused for now, and some that follow, so that they are
  /// requested again: the writer may have replaced them. Returns their octets, or nothing if there
  /// are none. Also returns nothing if, since the last call, the writer has announced nothing and
  /// no change was taken or given up.
  std::optional<std::size_t> forget_refused();
  /// Offers changes again that were refused for now. Returns false if none was taken.
  bool offer_again();
  PartialSamples& partial() { return partial_; }

  /// True if samples or fragments of them are missing up to `last`.
  bool misses_any(SequenceNumber last) const;
  /// Returns the samples from `base` up to `last` of which no fragment has arrived, as far as a set
  /// reaches.
  SequenceNumberSet missing(SequenceNumber base, SequenceNumber last) const;

  std::size_t early() const { return early_.size(); }
  /// Returns the number of changes that the writer has for this reader, if the next one was refused
  /// for now.
  std::uint64_t refused() const;
  const HeldOctets::Account& held() const { return held_; }
  /// Gives up the latest change or sample that is held; it is requested again. Does nothing if
  /// nothing is held.
  void forget_latest();

  // In this process:
  /// Returns the writer, if it is in this process; nullptr if its changes arrive in messages.
  StatefulWriter* local() const { return local_; }
  /// `last` is the last change that the writer has written until now.
  void attach(StatefulWriter& writer, SequenceNumber last);
  void detach() { local_ = nullptr; }
  /// Sets the next number: every change below was delivered, or will never be.
  void set_next(SequenceNumber next) { next_ = next; }

  QueryTimer query;
  std::unique_ptr<Contradictions> contradictions;  ///< nullptr if they are not looked for

 private:
  bool deliver_or_keep(SequenceNumber number, std::optional<Change> change);
  void advance();
  /// Ends the wait for a HEARTBEAT: nothing below `number` is delivered.
  void start_at(SequenceNumber number);
  void note_lost(SequenceNumber until);
  bool deliver(SequenceNumber number, Change& change);
  /// Goes back if the writer has not come as far as messages under former keys said.
  void correct(SequenceNumber last);

  MatchedWriter writer_;
  Common& common_;
  const bool is_reliable_;
  bool was_heard_ = false;
  bool is_started_ = false;  ///< true if a change arrived, or a HEARTBEAT gave its position
  /// True while it waits for a HEARTBEAT. Until then, all changes are kept.
  bool waits_for_heartbeat_ = false;
  SequenceNumber former_;      ///< position before the wait
  SequenceNumber lost_until_;  ///< missing changes below were counted as lost
  SequenceNumber delivered_;   ///< the last change that was delivered; 0 if there is none
  bool is_doubted_ = false;    ///< true from distrust_former_keys() to the next HEARTBEAT
  /// Follows the last change that came under the newest keys, or that they declared irrelevant.
  SequenceNumber newest_next_{1};
  SequenceNumber floor_{1};  ///< its value when the writer was doubted, or matched
  RecentMessages<Heartbeat> heartbeats_;
  SequenceNumber next_{1};
  SequenceNumber announced_;
  /// The values of announced() and next() at the last call of forget_refused().
  std::pair<SequenceNumber, SequenceNumber> forgotten_at_;
  SequenceNumber history_end_;  ///< the last change that its first HEARTBEAT announced
  HeldOctets::Account held_;
  EarlyChanges early_;
  PartialSamples partial_;
  StatefulWriter* local_ = nullptr;
};

}  // namespace ddssec::rtps
