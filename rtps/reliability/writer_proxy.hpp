// The state of a matched writer, as the reader knows it (WriterProxy of RTPS 8.4.10.4).
#pragma once

#include <functional>

#include "base/hash.hpp"
#include "rtps/reliability/early_changes.hpp"
#include "rtps/reliability/partial_samples.hpp"
#include "rtps/reliability/past_writers.hpp"
#include "rtps/reliability/question_timer.hpp"
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
  /// Digest of the keys that protect its samples; empty: unprotected. Only the writer can have
  /// created samples that arrive while the keys are the same, but an attacker may have kept some of
  /// them.
  std::optional<Sha256Digest> keys = {};
  /// The identity whose share of the limits it uses; empty: that of its participant.
  std::optional<GuidPrefix> identity = {};
  /// The writer sends what it keeps once more only to a reader that begins with number 0.
  bool begins_at_zero = false;
  GuidPrefix owner() const { return identity.value_or(guid.prefix); }
};

/// Delivers the writer's changes in order, each once. Changes that arrived early and samples with
/// missing fragments are kept until their turn. No I/O, clock or lock.
class WriterProxy {
 public:
  static constexpr std::size_t kMaxEarlyChanges = 2048;
  /// What forget_refused() forgets at once; in octets, one change at least.
  static constexpr std::size_t kMaxForgotten = 256, kMaxForgottenOctets = std::size_t{256} << 10;

  /// What the proxies of one reader have in common. It must outlive them.
  struct Common {
    /// Takes the change, or refuses it for now.
    std::function<bool(Change&)> deliver = {};
    /// Called with the number of changes that were given up although the writer did not declare
    /// them irrelevant.
    std::function<void(std::int64_t count)> lost = {};
    std::shared_ptr<HeldOctets> held = std::make_shared<HeldOctets>();
    EarlyChanges::Spare spare = {};
  };

  /// `reader_is_reliable`: if false, a reliable writer is treated as a best-effort one.
  WriterProxy(MatchedWriter writer, bool reader_is_reliable, Common& common);
  WriterProxy(const WriterProxy&) = delete;
  WriterProxy& operator=(const WriterProxy&) = delete;

  const MatchedWriter& writer() const { return writer_; }
  void set_locators(LocatorList locators) { writer_.locators = std::move(locators); }
  /// True if missing changes are requested.
  bool is_reliable() const { return is_reliable_; }
  /// Everything below was delivered or given up.
  SequenceNumber next() const { return next_; }
  /// The last change that a HEARTBEAT announced.
  SequenceNumber announced() const { return announced_; }
  /// True if everything that it has announced was delivered or given up.
  bool has_caught_up() const { return next_ > announced_; }
  /// True if a HEARTBEAT has arrived.
  bool was_heard() const { return was_heard_; }
  /// True once everything has arrived that a reliable writer held when it was first heard.
  bool has_history() const { return !is_reliable_ || (was_heard_ && next_ > history_end_); }

  /// The writer was matched before and continues at its former position. `wants_history`: a
  /// HEARTBEAT with a later count than before may start again with what the writer holds; until a
  /// HEARTBEAT arrives nothing is delivered.
  void resume(const PastWriters::Position& past, bool wants_history);
  PastWriters::Position position(const Sha256Digest& keys) const {
    return {keys, next_, heartbeats_.last()};
  }

  /// True if the change was neither delivered nor given up, and is not held completely.
  bool lacks(SequenceNumber number) const { return number >= next_ && !early_.contains(number); }
  /// Takes a change with a number from next() on. `change`: empty if it is irrelevant. Returns
  /// false if it is already known, or there is no room to keep it.
  bool accept(SequenceNumber number, std::optional<Change> change);
  /// Returns false if the HEARTBEAT was received before. `is_protected`: by keys of the writer's
  /// participant.
  bool on_heartbeat(const Heartbeat& heartbeat, bool is_protected = true);
  /// True while the next HEARTBEAT determines where the writer starts.
  bool waits_for_heartbeat() const { return waits_for_heartbeat_; }
  /// Delivers what is held below `number`, and gives up what is missing there.
  void skip_to(SequenceNumber number);
  /// Forgets the next change if it was refused for now, and some that follow, so that they are
  /// requested again: the writer may have replaced them. Returns their octets, or nothing if there
  /// are none. Does nothing, and returns nothing, if since this was called before the writer has
  /// announced nothing and nothing was taken or given up.
  std::optional<std::size_t> forget_refused();
  /// Delivers what was refused for now. Returns false if nothing was taken.
  bool offer_again();
  PartialSamples& partial() { return partial_; }

  /// True if samples or fragments of them are missing up to `last`.
  bool misses_any(SequenceNumber last) const;
  /// The samples up to `last` of which no fragment has arrived, as far as a set reaches from
  /// `base`.
  SequenceNumberSet missing(SequenceNumber base, SequenceNumber last) const;

  std::size_t early() const { return early_.size(); }
  /// The number of changes that the writer has for this reader, if the next one was refused for
  /// now.
  std::uint64_t refused() const;
  const HeldOctets::Account& held() const { return held_; }
  /// Gives up the latest change or sample that is held; it is requested again. Does nothing if
  /// nothing is held.
  void forget_latest();

  // In this process:
  /// nullptr: its changes arrive in messages.
  StatefulWriter* local() const { return local_; }
  /// `last`: the last change that the writer has written until now.
  void attach(StatefulWriter& writer, SequenceNumber last);
  void detach() { local_ = nullptr; }
  /// Everything below `next` was delivered, or will never be.
  void set_next(SequenceNumber next) { next_ = next; }

  QuestionTimer question;

 private:
  void advance();
  /// Ends the wait for a HEARTBEAT: nothing below `number` is delivered.
  void start_at(SequenceNumber number);
  void note_lost(SequenceNumber until);

  MatchedWriter writer_;
  Common& common_;
  const bool is_reliable_;
  bool was_heard_ = false;
  bool is_started_ = false;  ///< a change of it arrived, or a HEARTBEAT gave its position
  /// For a HEARTBEAT; until then all changes are kept.
  bool waits_for_heartbeat_ = false;
  SequenceNumber former_;      ///< position before the wait
  SequenceNumber lost_until_;  ///< what is missing below was counted as lost
  RecentMessages<Heartbeat> heartbeats_;
  SequenceNumber next_{1};
  SequenceNumber announced_;
  std::pair<SequenceNumber, SequenceNumber> forgotten_at_;  ///< announced() and next()
  SequenceNumber history_end_;  ///< the last change that its first HEARTBEAT announced
  HeldOctets::Account held_;
  EarlyChanges early_;
  PartialSamples partial_;
  StatefulWriter* local_ = nullptr;
};

}  // namespace ddssec::rtps
