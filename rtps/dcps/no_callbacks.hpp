// Keeps listeners from being called while objects are deleted that they may be using.
#pragma once

#include "rtps/dcps/participant_context.hpp"

namespace ddssec::rtps {

/// While it exists, no listener of the participant is called. The participant's thread goes on
/// serving sockets and timers.
class NoCallbacks {
 public:
  /// Waits until the listeners that are being called have returned. Errors:
  /// rtps_precondition_not_met (called from within a callback of this participant, or from one of
  /// another participant for which a callback of this one waits).
  static Result<NoCallbacks> begin(ParticipantContext& context);
  /// As begin, for the end of the participant, which cannot be refused. On an error, raises the
  /// event rtps_ended_in_listener and ends the process. `whose` is the participant.
  static NoCallbacks begin_or_terminate(ParticipantContext& context, const Guid& whose);

  NoCallbacks(NoCallbacks&& other) noexcept : context_(std::exchange(other.context_, nullptr)) {}
  NoCallbacks& operator=(NoCallbacks&&) = delete;
  ~NoCallbacks() {
    if (context_ != nullptr) context_->resume_callbacks();
  }

 private:
  explicit NoCallbacks(ParticipantContext& context) : context_(&context) {}
  ParticipantContext* context_;
};

}  // namespace ddssec::rtps
