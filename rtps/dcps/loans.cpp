#include "rtps/dcps/loans.hpp"

#include "rtps/dcps/entity.hpp"

namespace ddssec::rtps {

Result<std::size_t> LoanCount::add(std::size_t wanted, const std::string& topic) {
  auto left = left_.load();
  while (!left_.compare_exchange_weak(left, left - std::min(wanted, left))) continue;
  if (left > 0 || wanted == 0) return std::min(wanted, left);
  return fail(Code::rtps_precondition_not_met,
              {.document = std::string(lender_) + " of " + topic,
               .field = "loans at the same time",
               .expected = "at most " + std::to_string(max_),
               .found = "one more",
               .hint = "write the loans of a writer, and clear the loaned samples of a reader, "
                       "before asking for more"});
}

Status OctetLoan::check(const std::shared_ptr<LoanCount>& count, const std::string& topic) const {
  if (*this && ticket_.is_of(count)) return {};
  return precondition_not_met_error("writer of " + topic,
                                    "a loan of this writer that was not written",
                                    *this ? "a loan of another writer" : "one without a sample");
}

}  // namespace ddssec::rtps
