#include "rtps/reliability/piggyback_heartbeats.hpp"

#include <algorithm>

namespace ddssec::rtps {
namespace {

int samples_per_question(const Qos& qos) {
  constexpr auto kMax = PiggybackHeartbeats::kMaxSamplesPerRequest;
  if (qos.history.kind == HistoryKind::keep_last) return kMax;
  int out = kMax;
  for (const auto limit :
       {qos.resource_limits.max_samples, qos.resource_limits.max_samples_per_instance})
    if (limit != kLengthUnlimited) out = std::clamp(limit / 4, 1, out);
  return out;
}

}  // namespace

PiggybackHeartbeats::PiggybackHeartbeats(const Qos& qos)
    : samples_per_request_(samples_per_question(qos)) {}

}  // namespace ddssec::rtps
