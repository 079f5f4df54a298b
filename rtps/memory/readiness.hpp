// One descriptor that is readable when any of several sockets is.
#pragma once

#include "base/descriptor.hpp"
#include "rtps/memory/refusal.hpp"

namespace ddssec::rtps::memory {

/// A socket that is closed leaves by itself.
class Readiness {
 public:
  /// Error: no_socket.
  static Outcome<Readiness> make();

  bool add(int socket);
  int descriptor() const { return poll_.number(); }

 private:
  explicit Readiness(Descriptor poll) : poll_(std::move(poll)) {}

  Descriptor poll_;
};

}  // namespace ddssec::rtps::memory
