#include "rtps/dcps/no_callbacks.hpp"

#include <exception>

#include "rtps/dcps/entity.hpp"

namespace ddssec::rtps {

Result<NoCallbacks> NoCallbacks::begin(ParticipantContext& context) {
  DDSSEC_RETURN_IF_ERROR(check_not_in_callback(context));
  if (context.hold_callbacks(CallbackLock::Wait::while_it_ends)) return NoCallbacks(context);
  return precondition_not_met_error(
      "listener", "deletions that do not wait for each other",
      "one from within a listener that a listener of this participant "
      "waits for");
}

NoCallbacks NoCallbacks::begin_or_terminate(ParticipantContext& context, const Guid& whose) {
  const bool inside = context.in_callback();
  if (!inside && context.hold_callbacks(CallbackLock::Wait::first)) return NoCallbacks(context);
  context.services().events.raise(
      Event(Error(Code::rtps_ended_in_listener,
                  {.document = "participant " + whose.to_string(),
                   .expected = "its end after its listeners have returned",
                   .found = inside ? "its end within one of them"
                                   : "its end within a listener that one of them waits to end"})));
  std::terminate();
}

}  // namespace ddssec::rtps
