#include "rtps/memory/readiness.hpp"

#include <sys/epoll.h>

namespace ddssec::rtps::memory {

Outcome<Readiness> Readiness::make() {
  Descriptor poll(::epoll_create1(EPOLL_CLOEXEC));
  if (!poll) return refuse(Refusal::no_socket);
  return Readiness(std::move(poll));
}

bool Readiness::add(int socket) {
  epoll_event event{};
  event.events = EPOLLIN;
  return ::epoll_ctl(poll_.number(), EPOLL_CTL_ADD, socket, &event) == 0;
}

}  // namespace ddssec::rtps::memory
