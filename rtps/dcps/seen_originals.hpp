// What a reader already has, whoever sent it: writers, those that were restarted and those that
// keep samples for others may all send the same sample to a late joiner (ORIGINAL_WRITER_INFO).
#pragma once

#include <map>
#include <vector>

#include "rtps/reliability/change.hpp"

namespace ddssec::rtps {

/// Ranges of numbers for each original writer. Where the bounds are exceeded the oldest is
/// forgotten: then a sample may come twice, but none is missed.
class SeenOriginals {
 public:
  static constexpr std::size_t kMostWriters = 1024;
  static constexpr std::size_t kMostRanges = 256;  ///< of a writer

  bool contains(const Original& original) const;
  void add(const Original& original);
  std::size_t writers() const { return writers_.size(); }

 private:
  struct Range {
    std::int64_t first, last;
  };
  struct Writer {
    std::vector<Range> ranges;  ///< ascending, not adjacent
    std::uint64_t used = 0;
  };
  void forget_oldest();

  std::map<Guid, Writer> writers_;
  std::uint64_t uses_ = 0;
};

}  // namespace ddssec::rtps
