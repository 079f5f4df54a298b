// Sends handshake messages, as far as a peer that has not proven its addresses may be sent
// anything.
#pragma once

#include "rtps/reliability/message_sender.hpp"
#include "rtps/security/peer.hpp"

namespace ddssec::rtps {

/// See AmplificationLimit. Each message is sent at once and alone.
class HandshakeSender {
 public:
  explicit HandshakeSender(MessageSender& sender) : sender_(sender) {}

  /// 0, or the octets of the message, if so many may not be sent yet.
  std::size_t send(const Peer& peer, const GenericMessage& message, const LocatorList& addresses);
  /// The same, with a challenge, for one of our own peers.
  std::size_t send_auth_request(const Peer& peer, const GenericMessage& message,
                                LocatorList addresses);
  /// Asks a Cyclone DDS what it answers, as long as Peer::held_back is more than may be sent.
  void earn(Peer& peer, const LocatorList& addresses);

 private:
  MessageSender& sender_;
  std::int64_t last_number_ = 0;
};

}  // namespace ddssec::rtps
