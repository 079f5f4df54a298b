// Samples of one writer with missing fragments (RTPS 8.4.14.1).
#pragma once

#include <vector>

#include "rtps/reliability/fragment_set.hpp"
#include "rtps/reliability/held_octets.hpp"
#include "rtps/reliability/received_change.hpp"

namespace ddssec::rtps {

/// The samples are sorted by sequence number. The announced size of a sample is accepted up to the
/// limits below, and counted before its octets arrive.
class PartialSamples {
 public:
  static constexpr std::size_t kMaxSamples = 4;
  /// A sample of more fragments than this must have fragments of at least kMinFragmentSize octets,
  /// because each fragment has a cost besides its octets.
  static constexpr std::uint32_t kMaxSmallFragments = 4096;
  static constexpr std::uint16_t kMinFragmentSize = 512;
  /// The octets that each sample counts in addition to its payload.
  static constexpr std::size_t kPrice = 256;

  /// If there is one sample too many, the oldest one is dropped if `prefers_newest`, else the
  /// newest. `account` must outlive this object.
  PartialSamples(HeldOctets::Account& account, bool prefers_newest)
      : account_(account), prefers_newest_(prefers_newest) {}

  bool empty() const { return samples_.empty(); }
  bool contains(SequenceNumber number) const { return find(number) != samples_.end(); }
  SequenceNumber first() const { return samples_.front().number(); }
  SequenceNumber last() const { return samples_.back().number(); }
  /// Returns the missing fragments of the first sample, within 256 of the first missing one.
  FragmentNumberSet missing_of_first() const { return samples_.front().have.missing(); }

  /// Returns false if the fragment contradicts earlier fragments of its sample, or belongs to a
  /// sample of too many fragments.
  bool admits(const DataFrag& frag) const;
  /// Begins a sample, whose fragment must pass `admits` and which must not be contained. Returns
  /// false if there is no room.
  bool begin(const GuidPrefix& from, const DataFrag& frag, const std::optional<Time>& time);
  /// Inserts the fragments. Returns false if they had already arrived, or if the sample is not
  /// contained.
  bool insert(const DataFrag& frag);
  /// Removes and returns the sample if no fragment of it is missing.
  std::optional<Change> take_complete(SequenceNumber number);
  /// Removes samples first .. last.
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
