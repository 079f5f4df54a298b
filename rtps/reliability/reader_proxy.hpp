// The state of a matched reader, as the writer knows it (ReaderProxy of RTPS 8.4.7.5).
#pragma once

#include <memory>
#include <optional>

#include "rtps/reliability/acknowledged_numbers.hpp"
#include "rtps/reliability/change_filter.hpp"
#include "rtps/reliability/fragment_repair.hpp"
#include "rtps/reliability/key_payload.hpp"
#include "rtps/reliability/octet_allowance.hpp"
#include "rtps/reliability/recent_messages.hpp"
#include "rtps/reliability/rejected_ranges.hpp"
#include "wire/acknack.hpp"
#include "wire/locator.hpp"
#include "wire/nack_frag.hpp"

namespace ddssec::rtps {

class StatefulReader;

/// A reader that matched a local writer.
struct MatchedReader {
  Guid guid;
  bool is_reliable = false;
  bool wants_history = false;  ///< durability is TRANSIENT_LOCAL or higher
  LocatorList locators = {};   ///< empty if it gets changes directly in this process
  bool is_in_process = false;
  std::shared_ptr<ChangeFilter> filter = {};  ///< the reader gets everything if this is nullptr
  KeyReading keys = {};
};

/// Says whether a reader acknowledges in time: everything that was written before a point in time,
/// at most kMaxDelay later.
class Timeliness {
 public:
  static constexpr MonotonicTime kMaxDelay = std::chrono::milliseconds(500);

  /// Checks whether the reader is late. `written` is the last number that was written.
  void update(SequenceNumber acknowledged, SequenceNumber written, MonotonicTime now) {
    if (acknowledged >= awaited_) {
      awaited_ = written;
      due_ = now + kMaxDelay;
      is_late_ = false;
    } else if (now >= due_) {
      is_late_ = true;
    }
  }
  /// True until the reader has acknowledged what was awaited.
  bool is_late() const { return is_late_; }

 private:
  SequenceNumber awaited_;
  MonotonicTime due_{};
  bool is_late_ = false;
};

/// A matched reader, with the progress that it has acknowledged. No I/O, clock or lock.
class ReaderProxy {
 public:
  /// Readers of one identity may use up EvaluationAllowance. After this time, another reader gets a
  /// change without an evaluation, and decides.
  static constexpr MonotonicTime kMaxEvaluationWait = std::chrono::milliseconds(100);

  /// The changes that the reader gets.
  struct Range {
    SequenceNumber first;       ///< a late joiner gets no changes below this number
    SequenceNumber until = {};  ///< the reader gets no changes from here on; 0 if there is no limit
  };

  /// If `writer_is_reliable` is false, a reliable reader acknowledges nothing.
  ReaderProxy(MatchedReader reader, const Range& range, bool writer_is_reliable)
      : reader_(std::move(reader)),
        range_(range),
        acknowledges_(reader_.is_reliable && writer_is_reliable) {}
  ReaderProxy(const ReaderProxy&) = delete;
  ReaderProxy& operator=(const ReaderProxy&) = delete;

  const MatchedReader& reader() const { return reader_; }
  /// Sets where messages for the reader are sent (MatchedReaders::readdress).
  void set_locators(LocatorList locators) { reader_.locators = std::move(locators); }
  /// True if both sides are reliable.
  bool acknowledges() const { return acknowledges_; }
  SequenceNumber first_relevant() const { return range_.first; }
  /// Returns the number up to which every change has arrived. MatchedReaders sets it.
  SequenceNumber acknowledged() const { return acknowledged_; }
  void set_acknowledged(SequenceNumber through) { acknowledged_ = through; }

  // The changes that the reader gets:
  bool is_for(const Change& change) const { return !ends_before(change.sequence_number); }
  bool ends_before(SequenceNumber number) const {
    return range_.until.value != 0 && number >= range_.until;
  }
  /// Returns the result of the reader's filter. Empty if it has no filter, or must decide itself.
  std::optional<bool> filter_result(const Change& change) const {
    if (!reader_.filter || !change.is_alive()) return std::nullopt;
    return reader_.filter->passes(change);
  }
  /// True if the filter is evaluated before the change is repeated.
  bool is_evaluated_again(const Change& change) const {
    return reader_.filter && change.is_alive() && change.payload.size() <= kMaxEvaluatedOctets;
  }
  /// Evaluates the filter, and remembers a rejection.
  bool evaluate(const Change& change) {
    const bool passes = filter_result(change).value_or(true);
    if (!passes) rejected_.add(change.sequence_number);
    return passes;
  }
  /// Notes that the change did not pass the filter.
  void note_rejected(SequenceNumber number) { rejected_.add(number); }
  /// Returns the end of the range of rejected changes that contains `number`. Empty if `number` is
  /// not known to be rejected.
  std::optional<SequenceNumber> rejected_until(SequenceNumber number) const {
    return rejected_.end_of(number);
  }
  /// Call it if no evaluation is allowed now. Returns true if requests have waited for
  /// kMaxEvaluationWait, so that the change is sent without one. Then the next change waits again.
  bool try_skip_evaluation(MonotonicTime now) {
    if (!waits_since_) waits_since_ = now;
    if (now - *waits_since_ < kMaxEvaluationWait) return false;
    waits_since_ = now;
    return true;
  }
  void end_wait_for_evaluation() { waits_since_.reset(); }
  /// True if the reader may not get everything.
  bool is_filtered() const { return reader_.filter != nullptr || range_.until.value != 0; }
  void set_filter(std::shared_ptr<ChangeFilter> filter) {
    reader_.filter = std::move(filter);
    rejected_.clear();
  }

  /// Returns true if a request from `base` on was answered less than FragmentRepair::kAnswerTime
  /// ago. Otherwise records that it is answered now.
  bool was_just_answered(SequenceNumber base, MonotonicTime now) {
    if (base == last_answered_ && now - last_answer_ < FragmentRepair::kAnswerTime) return true;
    last_answered_ = base;
    last_answer_ = now;
    return false;
  }

  AcknowledgedNumbers::Place place;          ///< set if it acknowledges
  AcknowledgedNumbers::Place place_in_time;  ///< set if it acknowledges in time
  Timeliness timeliness;
  RecentMessages<AckNack> acknacks;
  RecentMessages<NackFrag> nack_frags;
  RepairAllowance allowance;
  FragmentRepair repair;
  StatefulReader* local = nullptr;  ///< the reader in this process; nullptr if it is not attached
  bool in_memory = false;           ///< its participant has mapped the writer's memory
  bool is_limited = false;          ///< AmplificationLimit limits what is sent to it
  bool wanted = true;               ///< true if the last change passed its filter
  /// The first change that did not pass its filter and for which no GAP was sent yet; 0 if there is
  /// none.
  SequenceNumber filtered_from = {};

 private:
  MatchedReader reader_;
  const Range range_;
  const bool acknowledges_;
  SequenceNumber acknowledged_;
  RejectedRanges rejected_;
  std::optional<MonotonicTime> waits_since_;  ///< set while a request waits for an evaluation
  SequenceNumber last_answered_;              ///< base of the request that was answered last
  MonotonicTime last_answer_{};
};

}  // namespace ddssec::rtps
