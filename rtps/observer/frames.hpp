// From what a network interface or a capture file gives to UDP datagrams: Ethernet and what Linux
// has in its place, IPv4 with its fragments, IPv6. No I/O.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.hpp"

namespace ddssec::rtps {

class Frames {
 public:
  /// IPv4 datagrams of which fragments are missing; one more, and the oldest is forgotten.
  static constexpr std::size_t kMostPartial = 64;

  struct Datagram {
    std::string from;  ///< the address
    std::uint16_t port = 0;
    Bytes payload;
  };
  /// True if `link`, a number of LINKTYPE_ of libpcap, can be read.
  static bool knows(int link);
  /// The datagram that a frame is, or completes; nothing for anything else.
  std::optional<Datagram> read(int link, BytesView frame);

 private:
  struct Fragment {
    std::size_t offset;
    Bytes octets;
  };
  struct Partial {
    Bytes key;  ///< addresses, protocol, number
    std::vector<Fragment> fragments;
    std::optional<std::size_t> size;  ///< known with the last one
  };
  std::optional<Datagram> read_ipv4(BytesView packet);
  std::optional<Bytes> reassemble(BytesView key, Fragment fragment, bool is_last);

  std::deque<Partial> partial_;  ///< oldest first
};

}  // namespace ddssec::rtps
