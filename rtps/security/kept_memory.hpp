// Segments that writers of this participant gave up, although peers may still have them mapped.
#pragma once

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/ids.hpp"
#include "rtps/memory/memory_end.hpp"
#include "rtps/memory/sample_slots.hpp"

namespace ddssec::rtps {

/// The form of the payloads in a segment.
enum class MemoryForm : std::uint8_t { none, plain, authenticated, encrypted };

/// Memory that a peer has mapped lasts as long as the peer wants, even after its participant has
/// gone. A segment is therefore counted until the system reports that it is gone. It is kept open
/// as long as other processes seem to have it (Segment::is_with_others), and its writer may use it
/// again when all participants that may have it may read. After that it is closed here. It still
/// counts until it is closed everywhere (MemoryEnd), because is_with_others does not notice a
/// descriptor that is only a path (O_PATH). No clock or lock.
class KeptMemory {
 public:
  /// Limit for segments that were given up because participants of one identity left.
  static constexpr std::size_t kMaxOfOne = 4;

  /// Participants that may have a segment.
  using Holders = std::set<GuidPrefix>;
  struct Segment {
    memory::SampleSlots slots;
    MemoryForm form = MemoryForm::none;
    Holders holders = {};
    std::string leaver = {};  ///< set by `take`: the identity for which it counted
  };

  /// Keeps a segment. `leaver` is the identity whose leaving was the reason; empty for any other
  /// reason.
  void keep(const EntityId& writer, Segment segment, std::string leaver);
  /// Keeps a segment that is not used again.
  void keep_retired(memory::SampleSlots slots);
  /// Returns the segment of the writer that has the most holders, if they are more than `others`
  /// and each of them may read. `needed` is the payload in octets.
  std::optional<Segment> take(const EntityId& writer, MemoryForm form, std::size_t needed,
                              std::size_t others,
                              const std::function<bool(const GuidPrefix&)>& may_read);
  /// Notes that the writer is removed, or writes in another form. Its segments are not used again.
  void remove_writer(const EntityId& writer);
  /// Closes segments that the other processes seem to have returned, and forgets those that are
  /// gone.
  void forget_returned();

  /// True if kMaxOfOne segments that this identity left are kept. It then gets no further one.
  bool is_full(const std::string& identity) const;
  std::size_t octets() const;
  std::size_t segments() const { return kept_.size(); }

 private:
  struct KeptSegment {
    EntityId writer;
    std::size_t octets = 0;
    std::string leaver;
    std::optional<Segment> segment;  ///< empty: closed here
    bool is_over = false;            ///< is not used again
    std::optional<memory::MemoryEnd> end = {};
  };
  static void close_returned(KeptSegment& one);

  std::vector<KeptSegment> kept_;
};

}  // namespace ddssec::rtps
