// Samples of one writer of which fragments are missing (RTPS 8.4.14.1).
#pragma once

#include <vector>

#include "rtps/reliability/fragment_set.hpp"
#include "rtps/reliability/held_octets.hpp"
#include "rtps/reliability/received_change.hpp"

namespace ddssec::rtps {

/// In the order of their numbers. What the writer announces of a sample's size is believed up to
/// the limits below, and counted before it comes.
class PartialSamples {
 public:
  static constexpr std::size_t kMaxSamples = 4;
  /// Samples of more fragments than that must have fragments of at least kMinFragmentSize: the
  /// number of fragments is what a sample costs beside its octets.
  static constexpr std::uint32_t kMaxSmallFragments = 4096;
  static constexpr std::uint16_t kMinFragmentSize = 512;
  /// What each sample counts beside its octets.
  static constexpr std::size_t kPrice = 256;

  /// `prefers_newest`: where a sample is one too many the oldest makes room for it, else the
  /// newest. `account` outlives it.
  PartialSamples(HeldOctets::Account& account, bool prefers_newest)
      : account_(account), prefers_newest_(prefers_newest) {}

  bool empty() const { return samples_.empty(); }
  bool contains(SequenceNumber number) const { return find(number) != samples_.end(); }
  SequenceNumber first() const { return samples_.front().number(); }
  SequenceNumber last() const { return samples_.back().number(); }
  /// Of the first sample, within 256 fragments of the first that is missing.
  FragmentNumberSet missing_of_first() const { return samples_.front().have.missing(); }

  /// False: it contradicts what came of the sample before, or makes it of too many fragments.
  bool admits(const DataFrag& frag) const;
  /// A sample that `admits` its fragment and is not contained. False: there is no room.
  bool begin(const GuidPrefix& from, const DataFrag& frag, const std::optional<Time>& time);
  /// False: the fragments were there, or the sample is not.
  bool insert(const DataFrag& frag);
  /// The sample, which leaves, if no fragment of it is missing.
  std::optional<Change> take_complete(SequenceNumber number);
  /// Forgets first .. last.
  void erase(SequenceNumber first, SequenceNumber last);

 private:
  struct Sample {
    Change change;
    std::uint16_t fragment_size = 0;
    FragmentSet have;
    std::size_t price = 0;
    SequenceNumber number() const { return change.sequence_number; }
  };
  using Samples = std::vector<Sample>;

  Samples::const_iterator find(SequenceNumber number) const;
  Samples::iterator find(SequenceNumber number);

  HeldOctets::Account& account_;
  const bool prefers_newest_;
  Samples samples_;
};

}  // namespace ddssec::rtps
