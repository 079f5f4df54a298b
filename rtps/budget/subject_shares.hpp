// Limits the places for authenticated participants that one certificate may claim.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <map>

#include "base/ids.hpp"

namespace ddssec::rtps {

/// Counts participants by the subject of their certificate. The first six octets of a proven GUID
/// identify the subject (DDS-Security 1.2, clause 10.3.3). A subject may have no more places than
/// are free. So the first subject takes at most half of them, and each further one still finds
/// some.
class SubjectShares {
 public:
  using Subject = std::array<std::uint8_t, 6>;
  static Subject subject_of(const GuidPrefix& prefix) {
    Subject out;
    std::copy_n(prefix.octets.begin(), out.size(), out.begin());
    return out;
  }

  explicit SubjectShares(std::size_t places) : places_(places) {}

  /// True if there is a place for one more participant of that subject.
  bool has_place(const GuidPrefix& prefix) const { return count(prefix) < places_ - taken_; }
  /// Returns the number of participants of that subject.
  std::size_t count(const GuidPrefix& prefix) const {
    const auto at = of_subject_.find(subject_of(prefix));
    return at == of_subject_.end() ? 0 : at->second;
  }
  /// Takes a place for a participant of that subject, also if has_place() is false.
  void claim(const GuidPrefix& prefix) {
    ++of_subject_[subject_of(prefix)];
    ++taken_;
  }
  /// Gives a place back. Must be called once for each claim() of that subject.
  void release(const GuidPrefix& prefix) {
    const auto at = of_subject_.find(subject_of(prefix));
    assert(at != of_subject_.end());
    if (at == of_subject_.end()) return;
    --taken_;
    if (--at->second == 0) of_subject_.erase(at);
  }

 private:
  const std::size_t places_;
  std::size_t taken_ = 0;
  std::map<Subject, std::size_t> of_subject_;
};

}  // namespace ddssec::rtps
