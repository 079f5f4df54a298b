#include "rtps/dcps/writer_lifespan.hpp"

namespace ddssec::rtps {

void WriterLifespan::add(SequenceNumber change, Duration lifespan, MonotonicTime now,
                         std::chrono::nanoseconds age) {
  if (!lifespan.is_infinite()) expiring_.emplace(now + lifespan.to_nanoseconds() - age, change);
}

void WriterLifespan::expire(MonotonicTime now, const std::function<void(SequenceNumber)>& expired) {
  for (; next_tick() <= now; expiring_.pop()) expired(expiring_.top().second);
}

}  // namespace ddssec::rtps
