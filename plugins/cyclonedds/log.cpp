#include "plugins/cyclonedds/log.hpp"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <string>

#include <dds/ddsrt/log.h>

#include "plugins/cyclonedds/event_file.hpp"
#include "plugins/cyclonedds/host_entities.hpp"

namespace ddssec::cyclonedds {
namespace {

LogFunction as_log_function(void* symbol) { return reinterpret_cast<LogFunction>(symbol); }

class HostLog final : public EventSink {
 public:
  HostLog(LogFunction log, const char* json_path) : log_(log) {
    if (json_path == nullptr || *json_path == '\0') return;
    json_path_ = json_path;
    json_ = std::make_unique<EventFile>(json_path);
    if (json_->is_open()) return;
    json_.reset();
    log_line(about_the_file("a file, a FIFO with a reader, or a terminal", "something else"));
  }

  void raise(const Event& event) override {
    log_line(event);
    if (json_) append(event);
  }

 private:
  /// A full disk or a slow reader must not stop a refusal. The loss is reported once, and the
  /// number of lost lines when lines can be written again.
  void append(const Event& event) {
    if (!json_->append(event.to_json())) {
      if (lost_.fetch_add(1) == 0)
        log_line(about_the_file("room for an event", "no room, or no reader that keeps up"));
      return;
    }
    const auto lost = lost_.exchange(0);
    if (lost == 0) return;
    const auto told =
        about_the_file("every event", std::to_string(lost) + " events before this one are lost");
    log_line(told);
    json_->append(told.to_json());
  }

  Event about_the_file(std::string expected, std::string found) const {
    return Event(Error(
        Code::event_log_unwritable,
        {.document = json_path_, .expected = std::move(expected), .found = std::move(found)}));
  }

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
  std::string json_path_;
  std::unique_ptr<EventFile> json_;
  std::atomic<std::uint64_t> lost_ = 0;  ///< events, since lines went in
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
      return DDS_LC_ERROR;  // never DDS_LC_FATAL: that aborts the process
  }
  return DDS_LC_ERROR;
}

std::uint32_t log_category(const Event& event) {
  switch (event.error.code()) {
    case Code::plugins_in_use:
    case Code::no_revocation_list:
    case Code::crl_renewed:
      return DDS_LC_WARNING;  // Cyclone DDS shows nothing below by default
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
