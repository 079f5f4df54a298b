// What was kept of other writers while some waited for room. No I/O, clock or lock.
#pragma once

#include <deque>
#include <map>
#include <set>

#include "rtps/durability/stored_change.hpp"

namespace ddssec::rtps {

/// A sample that waited must neither replace a later one of the same instance nor bring an ended
/// instance back. Later: by source timestamp. Timestamps count only for writers that waited:
/// otherwise a timestamp from the future would keep all others out.
class Overtaken {
 public:
  /// If more instances were written meanwhile, the oldest are forgotten.
  static constexpr std::size_t kMost = 4096;

  /// The writer's next change has no room.
  void wait(const Guid& writer) { waiting_.insert(writer); }
  void forget(const Guid& writer);
  /// All changes that wait are offered again. Writers of which none is refused wait no longer.
  void begin_pass() { returning_.swap(waiting_); }
  void end_pass();
  /// The change is kept. It has a source timestamp.
  void note(const Change& kept);
  /// True if the change waited, and another writer wrote its instance later.
  /// `ends_only`: ... and ended it later.
  bool is_overtaken(const Change& change, bool ends_only) const;
  std::size_t size() const { return kept_.size(); }

 private:
  struct Kept {
    Guid writer;
    Time time;
    bool is_end;
  };
  std::set<Guid> waiting_, returning_;
  std::map<KeyHash, Kept> kept_;
  std::deque<KeyHash> order_;  ///< of kept_, oldest first
};

}  // namespace ddssec::rtps
