// The boundary between C and C++. No exception leaves an exported function. Any failure denies,
// fills the host's SecurityException and raises one event.
#pragma once

#include <exception>
#include <new>
#include <system_error>
#include <utility>

#include "base/result.hpp"
#include "plugins/cyclonedds/abi.hpp"
#include "plugins/cyclonedds/host.hpp"

namespace ddssec::cyclonedds {

/// Fills in the message (one malloc block, which the host frees), code and minor code. `ex` may be
/// null.
void fill_exception(Exception* ex, const Error& error, DDS_Security_long code) noexcept;

/// As fill_exception, with a short message, for an error that an event reports in full. The host
/// logs the message, too.
void fill_exception_of_logged(Exception* ex, const Error& error, DDS_Security_long code) noexcept;

/// The way in which a failure is reported: the code in the host's exception, and the event, if one
/// is raised.
struct FailureReport {
  DDS_Security_long host_code;
  Severity severity;
  bool raises_event = true;
};
/// Returns the default report: number and severity of the Code. For keys_not_permitted access
/// control raises the event, and for announcements_delayed cryptography does, once in a while.
/// After crypto_tokens_early the sender repeats the tokens, so it raises none.
inline FailureReport default_report(const Error& error) {
  return {static_cast<DDS_Security_long>(error.code()), info(error.code()).severity,
          error.code() != Code::keys_not_permitted && error.code() != Code::announcements_delayed &&
              error.code() != Code::crypto_tokens_early};
}

/// Returns the Error for an exception. Never throws.
Error caught_error(const std::exception* thrown) noexcept;

/// Runs `f`, which returns a Result, catches all exceptions, and reports a failure as `tell(error)`
/// demands.
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
      // For example, no further thread can be created here.
      if (thrown.code() == std::errc::resource_unavailable_try_again)
        return fail(Code::out_of_memory);
      return std::unexpected(caught_error(&thrown));
    } catch (const std::exception& thrown) {
      return std::unexpected(caught_error(&thrown));
    } catch (...) {
      return std::unexpected(caught_error(nullptr));
    }
  }();
  if (!outcome) [[unlikely]] {
    const FailureReport report = tell(outcome.error());
    fill_exception_of_logged(ex, outcome.error(), report.host_code);
    // If the plugin raised its own event, with subject and GUID, that one is better.
    if (report.raises_event && Host::raised_by_this_thread() == raised_before)
      host.refused(outcome.error(), report.severity);
  }
  return outcome;
}

template <class F>
auto at_c_boundary(Host& host, Exception* ex, F&& f) noexcept -> decltype(std::forward<F>(f)()) {
  return at_c_boundary(host, ex, std::forward<F>(f), default_report);
}

/// Returns the outcome as C boolean: 1 for success, otherwise 0.
template <class F>
DDS_Security_boolean allowed_at_c_boundary(Host& host, Exception* ex, F&& f) noexcept {
  return at_c_boundary(host, ex, std::forward<F>(f)) ? 1 : 0;
}

/// Returns the outcome as C handle: nil unless it is a success.
template <class F>
DDS_Security_long_long handle_at_c_boundary(Host& host, Exception* ex, F&& f) noexcept {
  const auto handle = at_c_boundary(host, ex, std::forward<F>(f));
  return handle ? handle->value : DDS_SECURITY_HANDLE_NIL;
}

/// Fills the exception when the host passes no instance.
inline void refuse_null_instance(Exception* ex) noexcept {
  const Error error(Code::null_argument);
  fill_exception(ex, error, default_report(error).host_code);
}

/// Success if all pointers are set. Error: null_argument.
template <class... Pointers>
Status require(const Pointers*... pointers) {
  if ((... && (pointers != nullptr))) return {};
  return fail(Code::null_argument);
}

}  // namespace ddssec::cyclonedds
