#include "rtps/dcps/participant_service.hpp"

#include "base/background_thread.hpp"

namespace ddssec::rtps {

Status ParticipantService::adopt(std::unique_ptr<Participant> protocol) {
  const std::lock_guard held(context_.mutex());
  context_.adopt(std::move(protocol));
  return sockets_->listen([this](UdpSocket& socket) { receive(socket); });
}

void ParticipantService::receive(UdpSocket& socket) {
  const auto count = socket.fetch();
  context_.serve([&] {
    const auto now = context_.now();
    const auto gathering = context_.protocol().gather();
    for (std::size_t i = 0; i < count; ++i)
      context_.protocol().receive(socket.datagram(i), now, socket.source(i));
    context_.protocol().note_backlog(count == UdpSocket::kBatch);
  });
}

void ParticipantService::start() {
  const std::lock_guard held(context_.mutex());
  started_ = true;
  if (!own_thread_) return;
  context_.protocol().allow_lingering();
  thread_ = start_background_thread<std::thread>([this] {
    while (!stopping_) serve(std::chrono::seconds(10));
  });
}

void ParticipantService::stop() {
  stopping_ = true;
  if (sockets_ != nullptr) wake();
  if (thread_.joinable()) thread_.join();
}

void ParticipantService::wake() { sockets_->loop().wake(); }

void ParticipantService::serve(std::chrono::nanoseconds most) {
  std::optional<MonotonicTime> until;
  context_.serve([&] {
    if (started_) until = context_.tick(most);
  });
  if (!until) return;
  if (context_.dispatch()) {
    const std::lock_guard held(context_.mutex());
    until = context_.next();
  }
  sockets_->loop().wait(std::max(*until - context_.now(), MonotonicTime::zero()));
  context_.dispatch();
}

}  // namespace ddssec::rtps
