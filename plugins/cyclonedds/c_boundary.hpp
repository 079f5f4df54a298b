// The one place where C meets C++: nothing leaves an exported function but its result. Whatever
// goes wrong inside denies, fills the host's SecurityException and raises one event.
#pragma once

#include <exception>
#include <new>
#include <system_error>
#include <utility>

#include "base/result.hpp"
#include "plugins/cyclonedds/abi.hpp"
#include "plugins/cyclonedds/host.hpp"

namespace ddssec::cyclonedds {

/// Message (one malloc block, the host frees it), code and minor code. A null `ex` is fine.
void fill_exception(Exception* ex, const Error& error, DDS_Security_long code) noexcept;

/// The same for an error that an event tells in full: the host logs the message, too, so it is
/// short.
void fill_exception_of_logged(Exception* ex, const Error& error, DDS_Security_long code) noexcept;

/// How a failure is told: the code in the host's exception, and the event, if there is to be one.
struct Telling {
  DDS_Security_long host_code;
  Severity severity;
  bool raises_event = true;
};
/// The number and the severity of the Code. Why keys are not permitted is told by access control.
inline Telling plainly(const Error& error) {
  return {static_cast<DDS_Security_long>(error.code()), info(error.code()).severity,
          error.code() != Code::keys_not_permitted};
}

/// An Error for an exception; never throws itself.
Error error_from(const std::exception* thrown) noexcept;

/// Runs `f` (returns a Result), catches everything, and tells a failure as `tell(error)` says.
template <class F, class Tell>
auto at_c_boundary(Host& host, Exception* ex, F&& f, Tell&& tell) noexcept
    -> decltype(std::forward<F>(f)()) {
  const auto raised_before = Host::raised_by_this_thread();
  auto outcome = [&]() noexcept -> decltype(std::forward<F>(f)()) {
    try {
      return std::forward<F>(f)();
    } catch (const std::bad_alloc&) {
      return fail(Code::out_of_memory);
    } catch (const std::system_error& thrown) {
      // No further thread, for one.
      if (thrown.code() == std::errc::resource_unavailable_try_again)
        return fail(Code::out_of_memory);
      return std::unexpected(error_from(&thrown));
    } catch (const std::exception& thrown) {
      return std::unexpected(error_from(&thrown));
    } catch (...) {
      return std::unexpected(error_from(nullptr));
    }
  }();
  if (!outcome) [[unlikely]] {
    const Telling telling = tell(outcome.error());
    fill_exception_of_logged(ex, outcome.error(), telling.host_code);
    // An engine that raised its own event, with subject and GUID, has said it better.
    if (telling.raises_event && Host::raised_by_this_thread() == raised_before)
      host.refused(outcome.error(), telling.severity);
  }
  return outcome;
}

template <class F>
auto at_c_boundary(Host& host, Exception* ex, F&& f) noexcept -> decltype(std::forward<F>(f)()) {
  return at_c_boundary(host, ex, std::forward<F>(f), plainly);
}

/// C's "boolean" of an outcome: anything but success is 0.
template <class F>
DDS_Security_boolean allowed_at_c_boundary(Host& host, Exception* ex, F&& f) noexcept {
  return at_c_boundary(host, ex, std::forward<F>(f)) ? 1 : 0;
}

/// C's handle of an outcome: anything but success is nil.
template <class F>
DDS_Security_long_long handle_at_c_boundary(Host& host, Exception* ex, F&& f) noexcept {
  const auto handle = at_c_boundary(host, ex, std::forward<F>(f));
  return handle ? handle->value : DDS_SECURITY_HANDLE_NIL;
}

/// What is left to say when the host gives no instance.
inline void refuse_null_instance(Exception* ex) noexcept {
  const Error error(Code::null_argument);
  fill_exception(ex, error, plainly(error).host_code);
}

/// Fails with null_argument unless all pointers are set.
template <class... Pointers>
Status require(const Pointers*... pointers) {
  if ((... && (pointers != nullptr))) return {};
  return fail(Code::null_argument);
}

}  // namespace ddssec::cyclonedds
