#include "base/status_service.hpp"

#include <atomic>
#include <cstdlib>
#include <mutex>
#include <unistd.h>
#include <utility>

#include "base/never_destroyed.hpp"
#include "base/status_server.hpp"

namespace ddssec {
namespace {

// The record and its socket.
struct Service {
  ~Service();

  DocumentsInUse documents = {};
  std::unique_ptr<StatusServer> server = {};  // destroyed before the record
};

struct Process {
  std::mutex mutex = {};
  std::weak_ptr<Service> service = {};
  std::atomic<pid_t> shown_by = 0;  // the process whose service lives, or 0
  bool has_reported_failure = false;
};

// Never destroyed, because it is used while the process exits.
Process& process() {
  static NeverDestroyed<Process> instance;
  return *instance;
}

Service::~Service() {
  auto own = ::getpid();
  process().shown_by.compare_exchange_strong(own, 0);
}

}  // namespace

std::shared_ptr<DocumentsInUse> shared_status_record(EventSink* events) {
  const char* const folder = ::secure_getenv("DDSSEC_STATUS_DIR");
  if (folder == nullptr || *folder == '\0') return nullptr;
  auto& own = process();
  // This is the child of a process with a service. A child must not take locks of its parent.
  if (own.shown_by != 0 && own.shown_by != ::getpid()) return nullptr;
  const std::scoped_lock lock(own.mutex);
  auto service = own.service.lock();
  if (!service) {
    service = std::make_shared<Service>();
    const auto& documents = service->documents;
    auto server = StatusServer::start(folder, [&documents] { return documents.to_json(); });
    if (!server) {
      if (events != nullptr && !std::exchange(own.has_reported_failure, true))
        events->raise(Event(server.error(), {}, {}, PeerProof::not_a_peer));
      return nullptr;
    }
    service->server = *std::move(server);
    own.service = service;
    own.shown_by = ::getpid();
  }
  return {service, &service->documents};
}

}  // namespace ddssec
