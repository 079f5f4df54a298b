#include "plugins/cyclonedds/log.hpp"

#include <cstdio>
#include <cstdlib>
#include <dlfcn.h>
#include <fcntl.h>
#include <string>
#include <unistd.h>

#include <dds/ddsrt/log.h>

namespace ddssec::cyclonedds {
namespace {

LogFunction as_log_function(void* symbol) { return reinterpret_cast<LogFunction>(symbol); }

/// Append-only, so that several processes and the three plugins of one may share a file: each line
/// is one write.
class JsonLines {
 public:
  explicit JsonLines(const char* path)
      : file_(open(path, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0640)) {}
  ~JsonLines() {
    if (is_open()) close(file_);
  }
  JsonLines(const JsonLines&) = delete;
  JsonLines& operator=(const JsonLines&) = delete;

  bool is_open() const { return file_ >= 0; }
  void append(const Event& event) const {
    const auto line = event.to_json() + "\n";
    // A full disk must not stop anybody from being refused.
    [[maybe_unused]] const auto written = write(file_, line.data(), line.size());
  }

 private:
  int file_;
};

class HostLog final : public EventSink {
 public:
  HostLog(LogFunction log, const char* json_path) : log_(log) {
    if (json_path == nullptr || *json_path == '\0') return;
    json_ = std::make_unique<JsonLines>(json_path);
    if (json_->is_open()) return;
    json_.reset();
    log_line(Event(Error(Code::event_log_unwritable, {.found = json_path})));
  }

  void raise(const Event& event) override {
    log_line(event);
    if (json_) json_->append(event);
  }

 private:
  void log_line(const Event& event) const {
    const auto category = log_category(event);
    if (category == 0) return;
    const auto line = event.to_line();
    if (log_ != nullptr) {
      // The events' texts are arguments, never formats: peers choose parts of them.
      log_(category, "ddssec", 0, "ddssec", "ddssec %s\n", line.c_str());
    } else {
      std::fprintf(stderr, "ddssec %s\n", line.c_str());
    }
  }

  LogFunction log_;
  std::unique_ptr<JsonLines> json_;
};

}  // namespace

LogFunction find_host_log(const void* caller) noexcept {
  Dl_info host{};
  if (caller != nullptr && dladdr(caller, &host) != 0 && host.dli_fname != nullptr) {
    // Already loaded, so this only counts up; libddsc may have been loaded without RTLD_GLOBAL.
    if (void* library = dlopen(host.dli_fname, RTLD_LAZY | RTLD_NOLOAD)) {
      void* symbol = dlsym(library, "dds_log");
      dlclose(library);
      if (symbol != nullptr) return as_log_function(symbol);
    }
  }
  return as_log_function(dlsym(RTLD_DEFAULT, "dds_log"));
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
      return DDS_LC_WARNING;  // Cyclone DDS shows nothing below, unless it is asked for more
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
