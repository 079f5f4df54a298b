#include "rtps/dcps/participant_service.hpp"

#include <pthread.h>
#include <system_error>

#include "base/background_thread.hpp"
#include "base/rollback.hpp"
#include "rtps/participant/shared_memory.hpp"

namespace ddssec::rtps {
namespace {

// If an exception ended work that was due, the work is due again after this time.
constexpr MonotonicTime kRetry = std::chrono::milliseconds(100);

// If more datagrams than this arrive at once, it is better to receive them while the application
// handles the first ones.
constexpr std::size_t kBulk = 2;

}  // namespace

Status ParticipantService::adopt(std::unique_ptr<RtpsParticipant> protocol) {
  const std::lock_guard held(context_.mutex());
  context_.adopt(std::move(protocol));
  const auto& core = context_.protocol().remote_participants().core();
  start_memory(core);
  if (const auto memory = memory_descriptor(core))
    DDSSEC_RETURN_IF_ERROR(sockets_->loop().watch(*memory, [this] { receive_memory(); }));
  return sockets_->listen([this](UdpSocket& socket) { receive(socket); });
}

void ParticipantService::follow_interfaces(std::vector<std::string> wanted) {
  wanted_interfaces_ = std::move(wanted);
  auto watch = InterfaceWatch::open();
  auto status = watch ? sockets_->loop().watch(watch->fd(), [this] { poll_interfaces(); })
                      : Status(std::unexpected(watch.error()));
  if (!status) {
    auto error = Error(Code::rtps_interfaces_unwatched, {.note = status.error().to_sentence()});
    return context_.services().events.raise(Event(std::move(error)));
  }
  watch_.emplace(std::move(*watch));
}

// An interface that was named and is gone may come back.
void ParticipantService::poll_interfaces() {
  if (!watch_->drain()) return;
  caught_.run("changed network interfaces", [&] {
    auto chosen = choose_interfaces(wanted_interfaces_);
    const bool were_gone = std::exchange(has_lost_interfaces_, !chosen);
    if (!chosen || (*chosen == sockets_->interfaces() && !were_gone)) return;
    context_.serve([&] { change_interfaces(std::move(*chosen)); });
  });
}

void ParticipantService::change_interfaces(std::vector<NetworkInterface> chosen) {
  auto& events = context_.services().events;
  auto former = to_string(sockets_->interfaces());
  for (auto& error : sockets_->use(std::move(chosen))) events.raise(Event(std::move(error)));
  context_.protocol().change_own(
      {.addresses =
           OwnChange::Addresses{sockets_->interfaces(), sockets_->metatraffic(), sockets_->user()}},
      context_.now());
  events.raise(Event(Error(
      Code::rtps_interfaces_changed,
      {.note = "now " + to_string(sockets_->interfaces()) + "; before " + std::move(former)})));
}

void ParticipantService::receive_memory() {
  caught_.run("shared memory", [&] {
    context_.serve(
        [&] { serve_memory(context_.protocol().remote_participants().core(), context_.now()); });
  });
}

void ParticipantService::receive(UdpSocket& socket) {
  caught_.run("received datagrams", [&] {
    const auto count = socket.fetch();
    if (turn_ != nullptr && count > kBulk) turn_->prefer_own(ServingTurn::kAfterBulk);
    context_.serve([&] { receive_batch(socket, count); });
  });
}

void ParticipantService::receive_batch(UdpSocket& socket, std::size_t count) {
  auto& protocol = context_.protocol();
  const auto now = context_.now();
  const auto gathering = protocol.gather();
  for (std::size_t i = 0; i < count; ++i)
    caught_.run("a received datagram",
                [&] { protocol.receive(socket.datagram(i), now, socket.source(i)); });
  protocol.note_backlog(count == UdpSocket::kBatch);
}

Status ParticipantService::start() {
  const std::lock_guard held(context_.mutex());
  is_started_ = true;
  if (turn_ == nullptr) return {};
  context_.protocol().allow_delayed_flush();
  try {
    thread_ = start_background_thread<std::thread>([this] { run(); });
  } catch (const std::system_error& error) {
    return fail(Code::rtps_thread_failed, {.document = "participant", .found = error.what()});
  }
  return {};
}

void ParticipantService::run() {
  while (turn_->await()) do
      serve(turn_->longest_own());
    while (!turn_->yield());
}

void ParticipantService::stop() {
  if (turn_ != nullptr) turn_->close();
  if (sockets_ != nullptr) sockets_->loop().wake();
  if (thread_.joinable()) thread_.join();
}

void ParticipantService::wake() {
  if (turn_ == nullptr || !turn_->take_over()) sockets_->loop().wake();
}

std::optional<MonotonicTime> ParticipantService::tick(std::chrono::nanoseconds timeout) {
  std::optional<MonotonicTime> until;
  const bool ticked = caught_.run("timers", [&] {
    context_.serve([&] {
      if (is_started_) until = context_.tick(timeout);
    });
  });
  if (!ticked) until = context_.now() + std::min<MonotonicTime>(timeout, kRetry);
  return until;
}

bool ParticipantService::dispatch() {
  bool any = false;
  const bool whole = caught_.run("a listener", [&] { any = context_.dispatch(); });
  any = any || !whole;
  if (any && turn_ != nullptr) turn_->prefer_own(ServingTurn::kAfterListeners);
  return any;
}

void ParticipantService::serve(std::chrono::nanoseconds timeout) {
  auto until = tick(timeout);
  if (!until) return;
  if (dispatch()) {
    const std::lock_guard held(context_.mutex());
    until = std::min(*until, context_.next());
  }
  sockets_->loop().wait(std::max(*until - context_.now(), MonotonicTime::zero()));
  dispatch();
}

// Cancellation is off while the thread serves: if it was cancelled in a system call, it would leave
// the participant's work half done.
void ParticipantService::serve_for_waiting(std::chrono::nanoseconds timeout,
                                           ServingTurn::WaitScope& waiting) {
  {
    int state = 0;
    ::pthread_setcancelstate(PTHREAD_CANCEL_DISABLE, &state);
    const Rollback restored([&] { ::pthread_setcancelstate(state, nullptr); });
    serve_once_for_waiting(timeout, waiting);
  }
  ::pthread_testcancel();
}

void ParticipantService::serve_once_for_waiting(std::chrono::nanoseconds timeout,
                                                ServingTurn::WaitScope& waiting) {
  const auto has_pending = [&] {
    const std::lock_guard held(context_.mutex());
    return context_.has_pending();
  };
  if (!waiting.begin_work()) return;
  const auto until = tick(timeout);
  const bool may_look = until && !has_pending();
  waiting.end_work();
  EventLoop::ReadableSockets readable;
  if (may_look)
    readable = sockets_->loop().poll(std::max(*until - context_.now(), MonotonicTime::zero()));
  if (!waiting.begin_work()) return;
  sockets_->loop().handle(readable);
  waiting.end_work();
  if (has_pending()) turn_->prefer_own(ServingTurn::kAfterListeners);
}

}  // namespace ddssec::rtps
