// A peer whose lease ended while it may keep its session with us.
#pragma once

#include "rtps/security/peer.hpp"

namespace ddssec::rtps {

/// The peer as it was, with its keys. It takes no part in anything until it answers a query that
/// was asked after the end of its lease (DormantPeers).
struct DormantPeer {
  Peer peer;
  MonotonicTime since{};
  bool is_asked = false;  ///< a query was written that it has not answered
  /// The earliest time for the next query, and when messages to the peer stop without an answer.
  MonotonicTime next_query{}, quiet_at = kNever;
};

}  // namespace ddssec::rtps
