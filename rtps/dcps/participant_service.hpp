// Serves the sockets, timers and listeners of a participant.
#pragma once

#include <thread>

#include "base/plugin_services.hpp"
#include "rtps/dcps/caught_exceptions.hpp"
#include "rtps/dcps/participant_context.hpp"
#include "rtps/participant/rtps_participant.hpp"
#include "rtps/transport/interface_watch.hpp"
#include "rtps/transport/participant_sockets.hpp"

namespace ddssec::rtps {

/// Runs in a thread of its own, or whenever serve is called. Owns the objects that the
/// participant's entities share. No exception leaves it: the datagram, timer or listener is
/// abandoned, counted and reported.
class ParticipantService final : private ParticipantContext::Server, private ServingTurn::Server {
 public:
  ParticipantService(const PluginServices& services, bool own_thread,
                     std::shared_ptr<ProcessPeers> process_peers)
      : turn_(own_thread ? std::make_shared<ServingTurn>(turn_server()) : nullptr),
        context_(services, *this, turn_, std::move(process_peers)),
        caught_(services.events) {}
  ~ParticipantService() override { stop(); }

  ParticipantContext& context() { return context_; }

  /// Call it before all others.
  void use(std::unique_ptr<ParticipantSockets> sockets) { sockets_ = std::move(sockets); }
  ParticipantSockets& sockets() const { return *sockets_; }
  /// Passes to the protocol what the sockets receive from now on. Errors: those of
  /// ParticipantSockets::listen.
  Status adopt(std::unique_ptr<RtpsParticipant> protocol);
  /// Begins to follow the changes of this machine's interfaces: sockets and protocol use those that
  /// choose_interfaces returns for `wanted`. If that is not possible, an event says so. Must be
  /// called after `adopt`.
  void follow_interfaces(std::vector<std::string> wanted);
  /// Begins to serve timers and listeners; starts the thread, if there is to be one. Errors:
  /// rtps_thread_failed.
  Status start();
  /// Returns the number of exceptions that were caught; never reset.
  std::uint64_t exceptions() const { return caught_.count(); }
  /// Ends the thread. Work that becomes due later is not done.
  void stop();

  /// Serves for at most `timeout`.
  void serve(std::chrono::nanoseconds timeout) override;

 private:
  void wake() override;
  void serve_for_waiting(std::chrono::nanoseconds timeout,
                         ServingTurn::WaitScope& waiting) override;
  void serve_once_for_waiting(std::chrono::nanoseconds timeout, ServingTurn::WaitScope& waiting);
  void end_serving() override { sockets_->loop().wake(); }
  void notify_waiting() override { context_.notify_waiting(); }
  ServingTurn::Server& turn_server() { return *this; }
  /// Does what is due. Returns the time until which to wait for the sockets; empty if not started.
  std::optional<MonotonicTime> tick(std::chrono::nanoseconds timeout);
  bool dispatch();
  void run();
  void receive(UdpSocket& socket);
  void poll_interfaces();
  void change_interfaces(std::vector<NetworkInterface> chosen);
  void receive_memory();
  void receive_batch(UdpSocket& socket, std::size_t count);

  const std::shared_ptr<ServingTurn> turn_;      ///< nullptr without a thread of its own
  std::unique_ptr<ParticipantSockets> sockets_;  // the protocol sends through them
  ParticipantContext context_;
  CaughtExceptions caught_;
  std::optional<InterfaceWatch> watch_;
  std::vector<std::string> wanted_interfaces_;
  bool has_lost_interfaces_ = false;  ///< one that was named is gone
  bool is_started_ = false;           ///< protected by the lock
  std::thread thread_;
};

}  // namespace ddssec::rtps
