#include "plugins/cryptography/receiver_places.hpp"

#include <string>

namespace ddssec::cryptography {

std::unexpected<Error> ReceiverPlaces::limit_error(std::size_t limit,
                                                   std::string_view whose) const {
  return fail(Code::receiver_places_taken,
              {.document = "origin authentication",
               .field = std::string(of_),
               .expected = "at most " + std::to_string(limit) + std::string(whose)});
}

Status ReceiverPlaces::claim(SubjectId subject) {
  if (all_ >= max_) return limit_error(max_, "");
  auto& count = of_subject_[subject];
  if (count >= share_of(max_)) return limit_error(share_of(max_), " of one certificate");
  ++count, ++all_;
  return {};
}

void ReceiverPlaces::release(SubjectId subject) noexcept {
  const auto found = of_subject_.find(subject);
  if (found == of_subject_.end()) return;
  --all_;
  if (--found->second == 0) of_subject_.erase(found);
}

}  // namespace ddssec::cryptography
