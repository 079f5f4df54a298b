#include "rtps/dcps/writer_lifespan.hpp"

namespace ddssec::rtps {

void WriterLifespan::add(SequenceNumber change, Duration lifespan, MonotonicTime now,
                         std::chrono::nanoseconds age) {
  if (!lifespan.is_infinite()) expiring_.push_back({now + lifespan.to_nanoseconds() - age, change});
}

void WriterLifespan::expire(MonotonicTime now, const std::function<void(SequenceNumber)>& expired) {
  for (; next_tick() <= now; expiring_.pop_front()) expired(expiring_.front().second);
}

}  // namespace ddssec::rtps
