// From the C pointer of the host to the C++ context that it belongs to.
#pragma once

#include <functional>
#include <memory>

#include "plugins/cyclonedds/c_boundary.hpp"

namespace ddssec::cyclonedds {

/// Creates an engine in the environment of its host.
template <class Engine>
using MakeEngine = std::function<std::unique_ptr<Engine>(const Environment&)>;

/// Calls `f(context) -> Result` inside the C boundary. A null instance is refused.
template <class Context, class Instance, class F>
DDS_Security_boolean ask(Instance* instance, Exception* ex, F&& f) noexcept {
  if (instance == nullptr) {
    refuse_null_instance(ex);
    return 0;
  }
  auto& context = Context::of(*instance);
  return allowed_at_c_boundary(context.host(), ex, [&] { return f(context); });
}

/// The same for functions that return a handle; `f` returns Result of a type with `.value`.
template <class Context, class Instance, class F>
DDS_Security_long_long ask_handle(Instance* instance, Exception* ex, F&& f) noexcept {
  if (instance == nullptr) {
    refuse_null_instance(ex);
    return DDS_SECURITY_HANDLE_NIL;
  }
  auto& context = Context::of(*instance);
  return handle_at_c_boundary(context.host(), ex, [&] { return f(context); });
}

}  // namespace ddssec::cyclonedds
