// Extracts UDP datagrams from the frames of a network interface or a capture file: Ethernet and its
// Linux equivalents, IPv4 with fragments, IPv6. No I/O.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.hpp"

namespace ddssec::rtps {

/// Reads frames one after the other, and keeps the fragments that belong together.
class Frames {
 public:
  /// The largest number of IPv4 datagrams with missing fragments. Above it, the oldest is
  /// forgotten.
  static constexpr std::size_t kMaxPartial = 64;

  struct Datagram {
    std::string from;  ///< the IP address
    std::uint16_t port = 0;
    Bytes payload;
  };
  /// True if `link`, a LINKTYPE_ number of libpcap, is supported.
  static bool knows(int link);
  /// Returns the datagram that the frame contains or completes; empty for anything else.
  std::optional<Datagram> read(int link, BytesView frame);

 private:
  struct Fragment {
    std::size_t offset;
    Bytes octets;
  };
  struct PartialDatagram {
    Bytes key;  ///< addresses, protocol, identification
    std::vector<Fragment> fragments;
    std::optional<std::size_t> size;  ///< known once the last fragment has arrived
  };
  std::optional<Datagram> read_ipv4(BytesView packet);
  std::optional<Bytes> reassemble(BytesView key, Fragment fragment, bool is_last);

  std::deque<PartialDatagram> partial_;  ///< oldest first
};

}  // namespace ddssec::rtps
