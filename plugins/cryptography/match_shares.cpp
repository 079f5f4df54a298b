#include "plugins/cryptography/match_shares.hpp"

#include <string>
#include <utility>

namespace ddssec::cryptography {

Status MatchShares::claim(SubjectId subject) {
  auto& count = of_subject_[subject];
  if (count >= kMaxOfSubject)
    return fail(Code::too_many_matches,
                {.document = "the discovery of a peer",
                 .expected = "at most " + std::to_string(kMaxOfSubject) +
                             " endpoints of one certificate that match one local endpoint"});
  ++count;
  return {};
}

void MatchShares::release(std::optional<SubjectId>& share) noexcept {
  const auto subject = std::exchange(share, std::nullopt);
  const auto found = subject ? of_subject_.find(*subject) : of_subject_.end();
  if (found != of_subject_.end() && --found->second == 0) of_subject_.erase(found);
}

}  // namespace ddssec::cryptography
