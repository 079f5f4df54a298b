#include "plugins/cryptography/work_debt.hpp"

#include <algorithm>
#include <cstdint>

namespace ddssec::cryptography {

void WorkDebt::charge(WorkUnits units, MonotonicTime now) {
  // More than this in one charge is as good as this, and cannot overflow.
  constexpr WorkUnits kMaxUnits = WorkUnits{1} << 30;
  until_ = std::max(until_, now) + price_ * static_cast<std::int64_t>(std::min(units, kMaxUnits));
}

}  // namespace ddssec::cryptography
