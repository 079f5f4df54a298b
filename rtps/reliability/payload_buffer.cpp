#include "rtps/reliability/payload_buffer.hpp"

namespace ddssec::rtps {

PayloadBuffer::PayloadBuffer(std::size_t expected)
    : payload_(Payload::uninitialized(Payload::memory_for(expected))),
      data_(payload_.fill().data()),
      capacity_(payload_.size()) {}

void PayloadBuffer::grow(std::size_t needed) {
  auto larger = Payload::uninitialized(Payload::memory_for(std::max(needed, 2 * capacity_)));
  std::ranges::copy(payload_.view().first(size_), larger.fill().begin());
  payload_ = std::move(larger);
  data_ = payload_.fill().data();
  capacity_ = payload_.size();
}

// A writer's history may keep the payload for long, so a small sample does not keep the memory of a
// large one.
Payload PayloadBuffer::finish() && {
  const auto octets = payload_.view().first(size_);
  if (Payload::memory_for(capacity_) > Payload::memory_for(size_)) return Payload::copy_of(octets);
  payload_.shrink(size_);
  return std::move(payload_);
}

}  // namespace ddssec::rtps
