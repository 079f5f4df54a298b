// A participant with its sockets and its thread: where applications begin.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "rtps/dcps/status.hpp"
#include "rtps/discovery/participant.hpp"
#include "rtps/transport/event_loop.hpp"

namespace ddssec::rtps {

struct DomainParticipantOptions {
  DomainId domain_id = 0;
  std::string domain_tag = {};
  std::string entity_name = {};
  Bytes user_data = {};
  std::string interface = "127.0.0.1";  ///< address of the interface to use
  bool multicast = false;               ///< announce to and listen at 239.255.0.1
  /// Addresses that are announced to by unicast, at the ports of participant indexes 0 to 9.
  std::vector<std::string> peers = {"127.0.0.1"};
  Duration lease_duration{{10, 0}};
  bool own_thread = true;  ///< false: the application calls poll()
};

/// Well-known ports (RTPS 9.6.2.3).
namespace ports {
inline constexpr int kMostIndexes = 120;
constexpr std::uint32_t base(DomainId domain) {
  return 7400 + 250 * static_cast<std::uint32_t>(domain);
}
constexpr std::uint32_t metatraffic(DomainId domain, int index) {
  return base(domain) + 10 + 2 * static_cast<std::uint32_t>(index);
}
constexpr std::uint32_t user(DomainId domain, int index) { return metatraffic(domain, index) + 1; }
}  // namespace ports

/// Writers and readers keep a reference: they die first. All calls are thread-safe; callbacks come
/// from the participant's thread (or from poll) and may write and take, but not delete endpoints.
class DomainParticipant {
 public:
  static constexpr int kAnnouncedIndexes = 10;

  /// Errors: invalid_property (no such domain or address), rtps_port_taken (all indexes),
  /// rtps_socket_failed, random_failed.
  static Result<std::unique_ptr<DomainParticipant>> create(DomainParticipantOptions options,
                                                           const Environment& environment);
  ~DomainParticipant();
  DomainParticipant(const DomainParticipant&) = delete;
  DomainParticipant& operator=(const DomainParticipant&) = delete;

  Guid guid() const { return {protocol_->prefix(), kEntityIdParticipant}; }
  int index() const { return index_; }
  ParticipantCounters counters() const;
  std::size_t remote_participants() const;

  /// Serves sockets and timers for at most `timeout`; only without a thread of its own.
  void poll(std::chrono::nanoseconds timeout);

 private:
  friend class WriterCore;
  friend class ReaderCore;
  class Sockets;

  DomainParticipant(DomainParticipantOptions options, const Environment& environment);
  Status open_sockets();
  Status start(const GuidPrefix& prefix);
  void serve_once(std::chrono::nanoseconds most);
  MonotonicTime now() const { return environment_.clock.monotonic(); }
  /// After something that changes when the protocol wants to be called.
  void reschedule();

  const DomainParticipantOptions options_;
  const Environment environment_;
  Locator interface_;
  int index_ = 0;
  std::unique_ptr<Sockets> sockets_;
  mutable std::recursive_mutex mutex_;
  std::condition_variable_any changed_;
  std::unique_ptr<Participant> protocol_;
  MonotonicTime waiting_until_ = kNever;
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

}  // namespace ddssec::rtps
