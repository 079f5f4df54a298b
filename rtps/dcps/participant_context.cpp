#include "rtps/dcps/participant_context.hpp"

#include "rtps/dcps/entity.hpp"
#include "rtps/participant/rtps_participant.hpp"

namespace ddssec::rtps {

thread_local const ParticipantContext::CallingScope* ParticipantContext::calling_ = nullptr;

ParticipantContext::ParticipantContext(const PluginServices& services, Server& server,
                                       std::shared_ptr<ServingTurn> turn,
                                       std::shared_ptr<ProcessPeers> process_peers)
    : services_(services),
      server_(server),
      turn_(std::move(turn)),
      process_peers_(std::move(process_peers)),
      mutex_(process_peers_->mutex()) {}

ParticipantContext::~ParticipantContext() = default;

const GuidPrefix& ParticipantContext::prefix() const { return protocol_->prefix(); }

void ParticipantContext::adopt(std::unique_ptr<RtpsParticipant> protocol) {
  protocol_ = std::move(protocol);
  process_peers_->enter(protocol_->local_endpoints());
}

void ParticipantContext::leave() { process_peers_->leave(protocol_->local_endpoints()); }

MonotonicTime ParticipantContext::tick(std::chrono::nanoseconds timeout) {
  is_woken_ = false;
  const auto time = now();
  if (protocol_->next_tick() <= time) protocol_->tick(time);
  timers_.run(time);
  // An earlier wake-up time is kept even if it is no longer needed. One wait that ends early costs
  // less than a call of wake for every sample, whose HEARTBEAT is due later and is not needed once
  // the sample is acknowledged.
  const auto kept = waiting_until_ > time ? waiting_until_ : kNever;
  waiting_until_ = std::min(time + timeout, kept);
  return next();
}

MonotonicTime ParticipantContext::next() {
  return waiting_until_ = std::min({waiting_until_, protocol_->next_tick(), timers_.next()});
}

// Within callbacks nothing is needed: after them, the serving thread checks next() itself.
void ParticipantContext::reschedule() {
  if (!in_callback()) wake_if(protocol_->next_tick());
}

void ParticipantContext::wake_if(MonotonicTime other) {
  if (is_woken_ || in_callback()) return;
  if (pending_.empty() && std::min(other, timers_.next()) >= waiting_until_) return;
  is_woken_ = true;
  server_.wake();
}

ParticipantContext::CallingScope::CallingScope(const ParticipantContext& context,
                                               CallbackLock::Wait wait)
    : context_(context), holds_(context.callbacks_.acquire(wait)), outer_(calling_) {
  calling_ = this;
}

ParticipantContext::CallingScope::~CallingScope() {
  calling_ = outer_;
  if (holds_) context_.callbacks_.release();
}

bool ParticipantContext::in_callback() const {
  for (const auto* one = calling_; one != nullptr; one = one->outer_)
    if (one->holds_ && &one->context_ == this) return true;
  return false;
}

void ParticipantContext::resume_callbacks() {
  callbacks_.release();
  const std::lock_guard lock(mutex_);
  wake_if(kNever);
}

bool ParticipantContext::dispatch() {
  bool any = false;
  {
    const std::lock_guard lock(mutex_);
    if (pending_.empty()) return false;
  }
  const CallingScope calling(*this, CallbackLock::Wait::none);
  while (calling) {
    Entity* entity = nullptr;
    {
      const std::lock_guard lock(mutex_);
      if (pending_.empty()) break;
      entity = pending_.front();
      entity->changes_.leave_queue();
    }
    entity->notify_listeners();
    any = true;
  }
  return any;
}

}  // namespace ddssec::rtps
