// What a reader knows of a writer that it matched (WriterProxy of RTPS 8.4.10.4).
#pragma once

#include <functional>

#include "base/hash.hpp"
#include "rtps/reliability/early_changes.hpp"
#include "rtps/reliability/partial_samples.hpp"
#include "rtps/reliability/past_writers.hpp"
#include "rtps/reliability/question_timer.hpp"
#include "wire/heartbeat.hpp"
#include "wire/locator.hpp"

namespace ddssec::rtps {

class StatefulWriter;

/// A writer that matched a local reader.
struct MatchedWriter {
  Guid guid;
  bool reliable = false;
  LocatorList locators = {};  ///< empty if it feeds us in this process
  bool in_process = false;
  /// What its samples are protected with, if anything: only the writer made those that come
  /// while it is the same, but an attacker may have kept some of them.
  std::optional<Sha256Digest> keys = {};
  /// Whose share of the bounds it takes; nothing: its participant's.
  std::optional<GuidPrefix> identity = {};
  GuidPrefix owner() const { return identity.value_or(guid.prefix); }
};

/// Delivers the writer's changes in order, each once. Changes that came too early and samples of
/// which fragments are missing are kept until their turn comes. No I/O, clock or lock.
class WriterProxy {
 public:
  static constexpr std::size_t kMaxEarlyChanges = 2048;

  /// What the proxies of one reader have in common. It outlives them.
  struct Common {
    /// Takes the change, or refuses it for now.
    std::function<bool(Change&)> deliver = {};
    /// Told how many changes were given up that the writer did not declare irrelevant.
    std::function<void(std::int64_t count)> lost = {};
    HeldOctets held = {};
    EarlyChanges::Spare spare = {};
  };

  /// `reader_is_reliable`: without it a reliable writer is treated as one of best effort.
  WriterProxy(MatchedWriter writer, bool reader_is_reliable, Common& common);
  WriterProxy(const WriterProxy&) = delete;
  WriterProxy& operator=(const WriterProxy&) = delete;

  const MatchedWriter& writer() const { return writer_; }
  /// What it lacks is asked for.
  bool is_reliable() const { return reliable_; }
  /// Everything below was delivered or given up.
  SequenceNumber next() const { return next_; }
  /// The last that a heartbeat spoke of.
  SequenceNumber announced() const { return announced_; }
  /// A heartbeat came.
  bool was_heard() const { return heard_; }
  /// True once everything has come that a reliable writer held when it was first heard.
  bool has_history() const { return !reliable_ || (heard_ && next_ > history_end_); }

  /// It was matched before, and goes on where it was. `wants_history`: a heartbeat that was not
  /// heard before may say that it starts anew with what it holds; until then nothing is delivered.
  void resume(const PastWriters::Position& past, bool wants_history);
  PastWriters::Position position(const Sha256Digest& keys) const {
    return {keys, next_, last_heartbeat_};
  }

  /// It was neither delivered nor given up, nor is it kept whole.
  bool lacks(SequenceNumber number) const { return number >= next_ && !early_.contains(number); }
  /// A number from next() on. `change`: nothing if it is irrelevant. False: it is known, or there
  /// is no room to keep it.
  bool accept(SequenceNumber number, std::optional<Change> change);
  /// False: it was heard before.
  bool on_heartbeat(const Heartbeat& heartbeat);
  /// True while the next heartbeat says where it starts.
  bool waits_for_heartbeat() const { return waits_; }
  /// What is held below `number` is delivered, what is missing there is given up.
  void skip_to(SequenceNumber number);
  /// Delivers what was refused for now. False: nothing was taken.
  bool offer_again();
  PartialSamples& partial() { return partial_; }

  /// Samples or parts of them, up to `last`.
  bool misses_any(SequenceNumber last) const;
  /// Up to `last`, as far as a set reaches from `base`: samples of which no part has come.
  SequenceNumberSet missing(SequenceNumber base, SequenceNumber last) const;

  std::size_t early() const { return early_.size(); }
  const HeldOctets::Account& held() const { return held_; }
  /// Gives up the latest of what is held: it is requested again. Not if nothing is held.
  void forget_latest();

  // In this process.
  /// nullptr: its changes come in messages.
  StatefulWriter* local() const { return local_; }
  /// `last`: what it has written until now.
  void attach(StatefulWriter& writer, SequenceNumber last);
  void detach() { local_ = nullptr; }
  /// Everything below `next` was delivered, or will never be.
  void set_next(SequenceNumber next) { next_ = next; }

  QuestionTimer question;

 private:
  void advance();
  void note_lost(SequenceNumber until);

  const MatchedWriter writer_;
  Common& common_;
  const bool reliable_;
  bool heard_ = false;
  bool started_ = false;  ///< a change of it came, or a heartbeat said where it stands
  bool waits_ = false;    ///< for a heartbeat later than last_heartbeat_, with all changes
  std::int32_t last_heartbeat_ = 0;
  SequenceNumber next_{1};
  SequenceNumber announced_;
  SequenceNumber history_end_;  ///< the last that its first heartbeat spoke of
  HeldOctets::Account held_;
  EarlyChanges early_;
  PartialSamples partial_;
  StatefulWriter* local_ = nullptr;
};

}  // namespace ddssec::rtps
