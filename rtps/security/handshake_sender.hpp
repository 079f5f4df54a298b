// Sends handshake messages, as far as AmplificationLimit allows sending to a peer that has not
// proven its addresses.
#pragma once

#include "rtps/reliability/message_sender.hpp"
#include "rtps/security/peer.hpp"

namespace ddssec::rtps {

/// Sends each message at once, in a datagram of its own.
class HandshakeSender {
 public:
  explicit HandshakeSender(MessageSender& sender) : sender_(sender) {}

  /// Returns 0 if the message was sent. Otherwise returns the message's octets, which may not be
  /// sent yet.
  std::size_t send(const Peer& peer, const GenericMessage& message, const LocatorList& addresses);
  /// As send, for an authentication request to a peer that also runs ddssec. It has a challenge for
  /// each host.
  std::size_t send_auth_request(const Peer& peer, const GenericMessage& message,
                                LocatorList addresses);
  /// Queries a Cyclone DDS peer as long as Peer::deferred_octets is more than what may be sent. Its
  /// answers increase what may be sent.
  void add_credit(Peer& peer, const LocatorList& addresses);

 private:
  MessageSender& sender_;
  std::int64_t last_number_ = 0;
};

}  // namespace ddssec::rtps
