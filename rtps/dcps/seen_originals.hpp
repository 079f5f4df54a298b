// What a reader already has, by any path: from writers, those that were restarted and those that
// keep samples for others may all send the same sample to a late joiner (ORIGINAL_WRITER_INFO).
#pragma once

#include <deque>
#include <map>
#include <vector>

#include "base/hash.hpp"
#include "rtps/reliability/change.hpp"

namespace ddssec::rtps {

/// Ranges of numbers for each writer that was heard itself. What only others said of a writer is a
/// claim: it takes the place of what the writer says, or another claims, only if that is the same,
/// so that no writer of a topic keeps others' samples away. Where the bounds are exceeded
/// the oldest is forgotten: then a sample may come twice, but none is missed.
class SeenOriginals {
 public:
  static constexpr std::size_t kMostWriters = 1024;
  static constexpr std::size_t kMostRanges = 256;  ///< of a writer
  static constexpr std::size_t kMostClaims = 65536;

  /// What is to be known of a change when it has been given away.
  struct Sighting {
    Original origin;
    std::optional<Sha256Digest> claim;  ///< what it says, if not its own writer does
  };
  static Sighting of(const Change& change);

  bool contains(const Change& change) const;
  void add(const Sighting& sighting);
  std::size_t writers() const { return writers_.size(); }
  std::size_t claims() const { return claims_.size(); }

 private:
  struct Range {
    std::int64_t first, last;
  };
  struct Writer {
    std::vector<Range> ranges;  ///< ascending, not adjacent
    std::uint64_t used = 0;
  };
  bool heard(const Original& original) const;
  void hear(const Original& original);
  void note_claim(const Original& original, const Sha256Digest& digest);
  void forget_oldest();

  std::map<Guid, Writer> writers_;
  std::uint64_t uses_ = 0;
  std::map<std::pair<Guid, SequenceNumber>, Sha256Digest> claims_;
  std::deque<std::pair<Guid, SequenceNumber>> order_;  ///< of claims, the oldest first
};

}  // namespace ddssec::rtps
