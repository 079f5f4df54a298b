#include "plugins/cyclonedds/host.hpp"

#include "base/status_service.hpp"

namespace ddssec::cyclonedds {
namespace {

thread_local unsigned raised_by_thread = 0;

}  // namespace

void Host::CountingSink::raise(const Event& event) {
  ++raised_by_thread;
  next_.raise(event);
}

const PluginServices& Host::services_with_record(bool reports) {
  documents_ = shared_status_record(reports ? &limited_ : nullptr);
  services_.documents = documents_.get();
  return services_;
}

unsigned Host::raised_by_this_thread() noexcept { return raised_by_thread; }

void Host::notice(const Event& event) noexcept { limited_.raise(event); }

void Host::refused(const Error& error, Severity severity) noexcept {
  Event event(error);  // this copies no text
  event.severity = severity;
  counted_.raise(event);
}

}  // namespace ddssec::cyclonedds
