#include "rtps/security/peer_event.hpp"

namespace ddssec::rtps {

Event peer_event(Error error, std::string guid, std::optional<std::string> proven_subject) {
  Event out(std::move(error), {}, std::move(guid), PeerProof::claimed);
  if (!proven_subject) return out;
  out.peer_subject = std::move(*proven_subject);
  out.proof = PeerProof::authenticated;
  return out;
}

}  // namespace ddssec::rtps
