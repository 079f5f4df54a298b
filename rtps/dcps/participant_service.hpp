// Serves the sockets, timers and listeners of a participant.
#pragma once

#include <atomic>
#include <thread>

#include "rtps/dcps/participant_context.hpp"
#include "rtps/transport/participant_sockets.hpp"

namespace ddssec::rtps {

/// In a thread of its own, or whenever serve is called. Owns what the participant's entities share.
class ParticipantService final : private ParticipantContext::Server {
 public:
  ParticipantService(const Environment& environment, bool own_thread,
                     std::shared_ptr<Neighbourhood> neighbourhood)
      : own_thread_(own_thread),
        context_(environment, *this, own_thread, std::move(neighbourhood)) {}
  ~ParticipantService() override { stop(); }

  ParticipantContext& context() { return context_; }

  /// First of all.
  void use(std::unique_ptr<ParticipantSockets> sockets) { sockets_ = std::move(sockets); }
  ParticipantSockets& sockets() const { return *sockets_; }
  /// The protocol gets what the sockets receive from now on. Errors: those of
  /// ParticipantSockets::listen.
  Status adopt(std::unique_ptr<Participant> protocol);
  /// Timers and listeners are served from now on, if wanted by a thread.
  void start();
  /// Ends the thread; what is due from here on stays undone.
  void stop();

  /// Serves for at most `most`.
  void serve(std::chrono::nanoseconds most) override;

 private:
  void wake() override;
  void receive(UdpSocket& socket);

  const bool own_thread_;
  std::unique_ptr<ParticipantSockets> sockets_;  // the protocol sends by them
  ParticipantContext context_;
  bool started_ = false;  ///< with the lock
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

}  // namespace ddssec::rtps
