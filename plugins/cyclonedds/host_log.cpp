#include "plugins/cyclonedds/host_log.hpp"

#include <cstdio>
#include <cstdlib>
#include <string>

#include <dds/ddsrt/log.h>

#include "base/event_log.hpp"
#include "plugins/cyclonedds/host_entities.hpp"

namespace ddssec::cyclonedds {
namespace {

LogFunction as_log_function(void* symbol) { return reinterpret_cast<LogFunction>(symbol); }

class HostLog final : public EventSink {
 public:
  HostLog(LogFunction log, const char* json_path) : log_(log), json_(json_path) {
    if (json_.write_failure()) log_line(*json_.write_failure());
  }

  void raise(const Event& event) override {
    log_line(event);
    if (const auto about_the_file = json_.append(event)) log_line(*about_the_file);
  }

 private:
  void log_line(const Event& event) const {
    const auto category = log_category(event);
    if (category == 0) return;
    const auto line = event.to_line();
    if (log_ != nullptr) {
      // The texts of events are arguments, never formats, because peers choose parts of them.
      log_(category, "ddssec", 0, "ddssec", "ddssec %s\n", line.c_str());
    } else {
      std::fprintf(stderr, "ddssec %s\n", line.c_str());
    }
  }

  LogFunction log_;
  EventLog json_;
};

}  // namespace

LogFunction find_host_log(const void* caller) noexcept {
  return as_log_function(find_host_symbol(caller, "dds_log"));
}

std::uint32_t log_category(Severity severity) {
  switch (severity) {
    case Severity::debug:
      return 0;
    case Severity::informational:
      return DDS_LC_INFO;
    case Severity::warning:
      return DDS_LC_WARNING;
    case Severity::error:
    case Severity::critical:
      return DDS_LC_ERROR;  // never DDS_LC_FATAL, because that aborts the process
  }
  return DDS_LC_ERROR;
}

std::uint32_t log_category(const Event& event) {
  switch (event.error.code()) {
    case Code::plugins_in_use:
    case Code::no_revocation_list:
    case Code::crl_renewed:
      return DDS_LC_WARNING;  // Cyclone DDS shows no lower category by default
    default:
      return log_category(event.severity);
  }
}

std::unique_ptr<EventSink> make_host_log(LogFunction log, const char* json_path) {
  return std::make_unique<HostLog>(log, json_path);
}

std::unique_ptr<EventSink> make_host_log_for(const void* caller) {
  return make_host_log(find_host_log(caller), std::getenv("DDSSEC_EVENT_LOG"));
}

}  // namespace ddssec::cyclonedds
