// The samples that a reader already has from any writer. Writers, restarted writers and durability
// services may all send the same sample to a late joiner (ORIGINAL_WRITER_INFO).
#pragma once

#include <deque>
#include <map>

#include "base/hash.hpp"
#include "rtps/reliability/change.hpp"

namespace ddssec::rtps {

/// Stores ranges of sequence numbers for each writer whose own samples were received. If only other
/// writers sent a sample of a writer, it is stored as a claim. A claim counts as already received
/// only for a sample with the same contents that lives no longer, so that no writer of a topic can
/// suppress samples of others. If a limit is exceeded, the oldest entry is forgotten: then a sample
/// may arrive twice, but none is missed. A number between two ranges may be that of a sample that
/// only a durability service still has, so ranges are never joined across it.
class SeenOriginals {
 public:
  static constexpr std::size_t kMaxWriters = 1024;
  /// The limit for the ranges of all writers together. If there are more, the writer with the most
  /// ranges loses its oldest ones, so each writer always keeps 64.
  static constexpr std::size_t kMaxRanges = 65536;
  static constexpr std::size_t kMaxClaims = 65536;

  /// The facts that must be remembered of a change after it has been passed on.
  struct Sighting {
    OriginalWriterInfo origin;
    /// Digest of the contents, if the change does not come from its own writer.
    std::optional<Sha256Digest> claim;
    MonotonicTime expires;  ///< the time at which the LIFESPAN of the writer ends it
  };
  static Sighting of(const Change& change, MonotonicTime expires = kNever);

  bool contains(const Change& change, MonotonicTime expires = kNever) const;
  void add(const Sighting& sighting);
  std::size_t writers() const { return writers_.size(); }
  std::size_t ranges() const { return ranges_; }
  std::size_t claims() const { return claims_.size(); }

 private:
  struct Range {
    std::int64_t first, last;
  };
  struct Writer {
    std::deque<Range> ranges;  ///< ascending, not adjacent
    std::uint64_t used = 0;
  };
  bool heard(const OriginalWriterInfo& original) const;
  void hear(const OriginalWriterInfo& original);
  struct Claim {
    Sha256Digest digest;
    MonotonicTime expires;
  };
  void note_claim(const OriginalWriterInfo& original, const Claim& claim);
  void forget_oldest();
  /// Forgets ranges of the writer with the most ranges.
  void forget_oldest_ranges();

  std::map<Guid, Writer> writers_;
  std::size_t ranges_ = 0;  ///< number of the ranges of all writers
  std::uint64_t uses_ = 0;
  std::map<std::pair<Guid, SequenceNumber>, Claim> claims_;
  std::deque<std::pair<Guid, SequenceNumber>> order_;  ///< the claims, oldest first
};

}  // namespace ddssec::rtps
