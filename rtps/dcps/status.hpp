// Communication statuses of DDS 1.4, 2.2.4.1, with what a person needs beside the counts.
#pragma once

#include "base/ids.hpp"
#include "rtps/qos/matching.hpp"

namespace ddssec::rtps {

/// PUBLICATION_MATCHED and SUBSCRIPTION_MATCHED.
struct MatchedStatus {
  std::int32_t total_count = 0;
  std::int32_t current_count = 0;
  Guid last_remote;
};

/// OFFERED_ and REQUESTED_INCOMPATIBLE_QOS.
struct IncompatibleQosStatus {
  std::int32_t total_count = 0;
  QosMismatch last;
};

}  // namespace ddssec::rtps
