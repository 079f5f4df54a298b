// Limits how many endpoints of one certificate match one local endpoint. At each match of a writer,
// Cyclone DDS looks at all readers that matched it before: with 5,000 readers of each of 30 writers
// its discovery stood still for minutes.
#pragma once

#include <cstddef>
#include <optional>
#include <unordered_map>

#include "base/result.hpp"
#include "plugins/cryptography/subject_id.hpp"

namespace ddssec::cryptography {

/// The matches of a local endpoint. Not thread-safe.
class MatchShares {
 public:
  static constexpr std::size_t kMaxOfSubject = 1024;

  /// Counts one more match of the subject. Error: too_many_matches.
  Status claim(SubjectId subject);
  /// Ends the match if it was counted; `share` is empty afterwards.
  void release(std::optional<SubjectId>& share) noexcept;

 private:
  std::unordered_map<SubjectId, std::size_t> of_subject_;
};

}  // namespace ddssec::cryptography
