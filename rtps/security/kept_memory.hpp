// Segments that writers of this participant gave up, although peers may still have them mapped.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/ids.hpp"
#include "rtps/memory/sample_slots.hpp"

namespace ddssec::rtps {

/// How payloads stand in a segment.
enum class MemoryForm : std::uint8_t { none, plain, encoded };

/// Memory that a peer has mapped lasts for as long as the peer wants, and nothing reports its end.
/// So a segment is counted until the participants that may have it are gone, and its writer uses
/// it again when all of them may read. No clock or lock.
class KeptMemory {
 public:
  /// Segments that were given up because participants of one identity left.
  static constexpr std::size_t kMostOfOne = 4;
  /// For how long memory counts after a participant has gone, or after its writer was removed.
  static constexpr MonotonicTime kAfterEnd = std::chrono::minutes(10);

  /// A participant that may have a segment, and since when it is gone.
  using Holders = std::map<GuidPrefix, std::optional<MonotonicTime>>;
  struct Segment {
    memory::SampleSlots slots;
    MemoryForm form = MemoryForm::none;
    Holders holders = {};
  };
  /// Whose leaving was the reason to give a segment up.
  struct Leaver {
    GuidPrefix participant = {};
    std::string identity = {};
  };

  void keep(const EntityId& writer, Segment segment, std::optional<Leaver> leaver);
  /// Returns the segment of the writer that has the most holders, if they are more than `others`
  /// and each of them may read. `needed`: payload in octets.
  std::optional<Segment> take(const EntityId& writer, MemoryForm form, std::size_t needed,
                              std::size_t others,
                              const std::function<bool(const GuidPrefix&)>& may_read);
  /// The writer is removed. Unmaps its segments.
  void remove_writer(const EntityId& writer, MonotonicTime now);
  /// Forgets what no participant has any longer.
  void forget(MonotonicTime now, const std::function<bool(const GuidPrefix&)>& is_here);

  bool is_full(const std::string& identity) const {
    return std::ranges::count_if(kept_, [&](const Kept& one) {
             return one.leaver && one.leaver->identity == identity;
           }) >= static_cast<std::ptrdiff_t>(kMostOfOne);
  }
  std::size_t octets() const;
  std::size_t segments() const { return kept_.size(); }

 private:
  struct Kept {
    EntityId writer;
    std::size_t octets = 0;
    std::optional<Segment> segment;  ///< empty: the writer was removed
    std::optional<Leaver> leaver;
    MonotonicTime until = kNever;
  };
  std::vector<Kept> kept_;
};

}  // namespace ddssec::rtps
