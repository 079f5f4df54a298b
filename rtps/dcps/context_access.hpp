// The participant's context, for the parts of ddssec outside this folder that work on a
// participant.
#pragma once

#include "rtps/dcps/domain_participant.hpp"

namespace ddssec::rtps {

/// The durability service (rtps/keeper) uses the protocol of its participant directly: it makes
/// writers and readers of octets that no application sees. No public header includes this one.
class ContextAccess {
 public:
  /// Returns the context that the participant's entities share. It lives as long as the
  /// participant.
  static ParticipantContext& of(const DomainParticipant& participant) {
    return participant.context_;
  }
};

}  // namespace ddssec::rtps
