// The truth: which participants exist, and what honest writers have written.
#pragma once

#include <map>
#include <optional>

#include "rtps/reliability/change.hpp"
#include "tests/sim/cast.hpp"

namespace ddssec::rtps::sim {

/// One life of a participant, from its start to its end or restart.
struct Life {
  const Subject* subject = nullptr;
  MonotonicTime born{};
  MonotonicTime died = kNever;
};

/// The data that an honest writer wrote as one sequence number.
struct Written {
  std::string_view topic;
  Bytes payload;
  StatusInfo status;
  std::optional<Time> time;
  MonotonicTime when{};
};

class Ledger {
 public:
  void enter(const GuidPrefix& prefix, const Life& life) { lives_[prefix] = life; }
  void leave(const GuidPrefix& prefix, MonotonicTime when) { lives_[prefix].died = when; }
  /// Returns nullptr if no participant ever had that name.
  const Life* life(const GuidPrefix& prefix) const {
    const auto at = lives_.find(prefix);
    return at == lives_.end() ? nullptr : &at->second;
  }
  const std::map<GuidPrefix, Life>& lives() const { return lives_; }

  /// Records what a writer wrote. Numbers begin at 1 and have no holes.
  void write(const Guid& writer, Written what) { written_[writer].push_back(std::move(what)); }
  /// Records that a durable writer, which does not `write`, still holds that number. The last call
  /// has its last number.
  void hold(const Guid& writer, SequenceNumber number, Written what) {
    held_[writer].insert_or_assign(number, std::move(what));
  }
  /// Returns what a durable writer holds; others hold nothing.
  const std::map<SequenceNumber, Written>& held(const Guid& writer) const {
    static const std::map<SequenceNumber, Written> nothing;
    const auto at = held_.find(writer);
    return at == held_.end() ? nothing : at->second;
  }
  /// Returns nullptr if it never wrote that many, or holds the number no longer.
  const Written* written(const Guid& writer, SequenceNumber number) const {
    const auto& durable = held(writer);
    if (const auto one = durable.find(number); one != durable.end()) return &one->second;
    const auto at = written_.find(writer);
    const bool known = at != written_.end() && number.value >= 1 && number.value <= count(writer);
    return known ? &at->second[static_cast<std::size_t>(number.value - 1)] : nullptr;
  }
  std::int64_t count(const Guid& writer) const {
    if (const auto& durable = held(writer); !durable.empty()) return durable.rbegin()->first.value;
    const auto at = written_.find(writer);
    return at == written_.end() ? 0 : static_cast<std::int64_t>(at->second.size());
  }

 private:
  std::map<GuidPrefix, Life> lives_;
  std::map<Guid, std::vector<Written>> written_;
  std::map<Guid, std::map<SequenceNumber, Written>> held_;
};

/// A part of every sample, by which a sample is found wherever it should not be readable.
inline constexpr std::string_view kMark = "ddssec sample that nobody else may read";

}  // namespace ddssec::rtps::sim
