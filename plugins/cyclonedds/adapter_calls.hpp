// Turns the C pointer of the host into the C++ context to which it belongs.
#pragma once

#include <functional>
#include <memory>

#include "base/plugin_services.hpp"
#include "plugins/cyclonedds/c_boundary.hpp"
#include "plugins/cyclonedds/token_translation.hpp"

namespace ddssec::cyclonedds {

/// Creates a plugin with the services of its host.
template <class Plugin>
using MakePlugin = std::function<std::unique_ptr<Plugin>(const PluginServices&)>;

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

/// As the function above, for functions that return a handle; `f` returns Result of a type with
/// `.value`.
template <class Context, class Instance, class F>
DDS_Security_long_long ask_handle(Instance* instance, Exception* ex, F&& f) noexcept {
  if (instance == nullptr) {
    refuse_null_instance(ex);
    return DDS_SECURITY_HANDLE_NIL;
  }
  auto& context = Context::of(*instance);
  return handle_at_c_boundary(context.host(), ex, [&] { return f(context); });
}

/// Puts a copy of the token that `f(context) -> Result<spi::Token>` returns into `*out`, which is
/// nil if there is none.
template <class Context, class Instance, class F>
DDS_Security_boolean ask_token(Instance* instance, DDS_Security_DataHolder* out, Exception* ex,
                               F&& f) noexcept {
  return ask<Context>(instance, ex, [&](Context& context) -> Status {
    DDSSEC_RETURN_IF_ERROR(require(out));
    *out = {};
    DDSSEC_ASSIGN_OR_RETURN(const spi::Token token, f(context));
    return copy_token(token, *out);
  });
}

/// Frees a token of ask_token. The host declares it const although it gives it back, and never uses
/// it again.
template <class Context, class Instance>
DDS_Security_boolean return_token(Instance* instance, const DDS_Security_DataHolder* token,
                                  Exception* ex) noexcept {
  return ask<Context>(instance, ex, [&](Context&) -> Status {
    if (token != nullptr) free_token(const_cast<DDS_Security_DataHolder&>(*token));
    return {};
  });
}

/// Takes the functions by which the plugin informs the host of events.
template <class Context, class Instance, class Listener>
DDS_Security_boolean set_listener(Instance* instance, const Listener* listener,
                                  Exception* ex) noexcept {
  return ask<Context>(instance, ex, [&](Context& context) -> Status {
    context.listen(listener);
    return {};
  });
}

}  // namespace ddssec::cyclonedds
