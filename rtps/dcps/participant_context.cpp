#include "rtps/dcps/participant_context.hpp"

#include "rtps/dcps/entity.hpp"

namespace ddssec::rtps {

thread_local const ParticipantContext* ParticipantContext::dispatching_ = nullptr;

MonotonicTime ParticipantContext::tick(std::chrono::nanoseconds most) {
  const auto time = now();
  if (protocol_->next_tick() <= time) protocol_->tick(time);
  timers_.run(time);
  return waiting_until_ = std::min({protocol_->next_tick(), timers_.next(), time + most});
}

void ParticipantContext::reschedule() {
  if (!pending_.empty() || std::min(protocol_->next_tick(), timers_.next()) < waiting_until_)
    server_.wake();
}

void ParticipantContext::dispatch() {
  const std::lock_guard callbacks(callbacks_);
  const auto* before = std::exchange(dispatching_, this);
  for (;;) {
    Entity* entity = nullptr;
    {
      const std::lock_guard lock(mutex_);
      if (pending_.empty()) break;
      entity = pending_.front();
      entity->pending_.leave();
    }
    entity->tell_listeners();
  }
  dispatching_ = before;
}

}  // namespace ddssec::rtps
