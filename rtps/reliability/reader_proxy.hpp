// What a writer knows of a reader that it matched (ReaderProxy of RTPS 8.4.7.5).
#pragma once

#include <memory>

#include "rtps/reliability/acknowledged_numbers.hpp"
#include "rtps/reliability/change_filter.hpp"
#include "rtps/reliability/fragment_repair.hpp"
#include "rtps/reliability/key_payload.hpp"
#include "rtps/reliability/octet_allowance.hpp"
#include "wire/locator.hpp"

namespace ddssec::rtps {

class StatefulReader;

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

/// The count of the last request of one kind: older ones are repeated, by the network or by an
/// attacker.
class LastCount {
 public:
  /// False: it is no later than the last.
  bool take(std::int32_t count) {
    if (!is_later(count, last_) && last_ != 0) return false;
    last_ = count;
    return true;
  }

 private:
  std::int32_t last_ = 0;
};

/// No I/O, clock or lock.
class ReaderProxy {
 public:
  /// Which changes it gets.
  struct Range {
    SequenceNumber first;       ///< what a late joiner does not get lies below
    SequenceNumber until = {};  ///< it gets nothing from here on; 0: everything
  };

  /// `writer_is_reliable`: without it a reliable reader acknowledges nothing.
  ReaderProxy(MatchedReader reader, const Range& range, bool writer_is_reliable)
      : reader_(std::move(reader)),
        range_(range),
        acknowledges_(reader_.reliable && writer_is_reliable) {}
  ReaderProxy(const ReaderProxy&) = delete;
  ReaderProxy& operator=(const ReaderProxy&) = delete;

  const MatchedReader& reader() const { return reader_; }
  /// Both sides are reliable.
  bool acknowledges() const { return acknowledges_; }
  SequenceNumber first_relevant() const { return range_.first; }
  /// Everything up to here has arrived. Kept by MatchedReaders.
  SequenceNumber acknowledged() const { return acknowledged_; }
  void set_acknowledged(SequenceNumber through) { acknowledged_ = through; }

  // Which changes it gets.
  bool accepts(const Change& change) const {
    return is_for(change) && filter_result(change).value_or(true);
  }
  bool is_for(const Change& change) const { return !ends_before(change.sequence_number); }
  bool ends_before(SequenceNumber number) const {
    return range_.until.value != 0 && number >= range_.until;
  }
  /// What its filter says; nothing: it has none, or the reader must judge itself.
  std::optional<bool> filter_result(const Change& change) const {
    if (!reader_.filter || !change.is_alive()) return std::nullopt;
    return reader_.filter->passes(change);
  }
  /// It may not get everything.
  bool is_filtered() const { return reader_.filter != nullptr || range_.until.value != 0; }
  void set_filter(std::shared_ptr<ChangeFilter> filter) { reader_.filter = std::move(filter); }

  /// A request from `base` on was answered less than FragmentRepair::kAnswerTime ago; else it is
  /// from now on.
  bool was_just_answered(SequenceNumber base, MonotonicTime now) {
    if (base == last_answered_ && now - last_answer_ < FragmentRepair::kAnswerTime) return true;
    last_answered_ = base;
    last_answer_ = now;
    return false;
  }

  AcknowledgedNumbers::Place place;  ///< if it acknowledges
  LastCount acknacks, nack_frags;
  RepairAllowance allowance;
  FragmentRepair repair;
  StatefulReader* local = nullptr;  ///< in this process; nullptr: not attached
  bool wanted = true;               ///< the last change passed its filter
  /// It was not told yet that from here on nothing passed its filter; or 0.
  SequenceNumber filtered_from = {};

 private:
  MatchedReader reader_;
  const Range range_;
  const bool acknowledges_;
  SequenceNumber acknowledged_;
  SequenceNumber last_answered_;  ///< base of the request that was answered last, and when
  MonotonicTime last_answer_{};
};

}  // namespace ddssec::rtps
