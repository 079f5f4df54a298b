// The network interfaces of this machine.
#pragma once

#include <string>

namespace ddssec::rtps {

/// The IPv4 address of the first interface that is up, no loopback and fit for multicast, as other
/// vendors choose theirs; "127.0.0.1" without any.
std::string default_interface();

}  // namespace ddssec::rtps
