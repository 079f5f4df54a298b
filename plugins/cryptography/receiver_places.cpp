#include "plugins/cryptography/receiver_places.hpp"

#include <string>

namespace ddssec::cryptography {
namespace {

std::unexpected<Error> refuse(std::size_t most, std::string_view whose) {
  return fail(Code::receiver_count,
              {.document = "origin authentication",
               .field = "readers of a writer",
               .expected = "at most " + std::to_string(most) + std::string(whose),
               .note = "this one gets no keys, the others go on; if the peer announces readers "
                       "without need, treat it as hostile, and revoke its certificate"});
}

}  // namespace

Status ReceiverPlaces::take(std::uint64_t subject) {
  if (all_ >= kMost) return refuse(kMost, "");
  auto& count = of_subject_[subject];
  if (count >= kMostOfSubject) return refuse(kMostOfSubject, " of one certificate");
  ++count, ++all_;
  return {};
}

void ReceiverPlaces::give_back(std::uint64_t subject) noexcept {
  const auto found = of_subject_.find(subject);
  if (found == of_subject_.end()) return;
  --all_;
  if (--found->second == 0) of_subject_.erase(found);
}

}  // namespace ddssec::cryptography
