// The samples of a reader in the order of their arrival, whatever their instance (PRESENTATION with
// ordered access, DDS 1.4, 2.2.3.6).
#pragma once

#include "rtps/dcps/held_instance.hpp"

namespace ddssec::rtps {

/// Knows the samples that were read and those that were not separately. So an access to the first
/// unread samples costs the same however many samples are held before them.
class ArrivalOrder {
 public:
  struct Entry {
    HeldInstance* instance;
    HeldSamples::iterator sample;
  };
  /// The instance and the sample must outlive the entry.
  void insert(HeldInstance& instance, HeldSamples::iterator sample);
  /// Both do nothing if the sample is not known.
  void erase(const HeldSample& sample);
  /// Call it before the sample is read.
  void mark_read(const HeldSample& sample);
  void clear();
  /// Returns the first `max_samples` samples, or fewer, that are in these states.
  std::vector<Entry> first(const States& states, std::size_t max_samples) const;

 private:
  using Entries = std::map<std::uint64_t, Entry>;  ///< by arrival
  Entries unread_, read_;
};

}  // namespace ddssec::rtps
