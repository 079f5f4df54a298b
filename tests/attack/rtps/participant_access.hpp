// What a hostile host does with its own participant, and what another vendor does not do: neither
// has a place in the interface of RtpsParticipant.
#pragma once

#include "rtps/participant/rtps_participant.hpp"

namespace ddssec::rtps::testing {

/// Mutable references into a participant. This is safe because no participant of a test is const.
struct ParticipantAccess {
  static LocalEndpoints& local_endpoints(RtpsParticipant& participant) {
    return const_cast<LocalEndpoints&>(participant.local_endpoints());
  }
  /// What `participant` knows of a peer, which must be known to it.
  static RemoteParticipant& peer(RtpsParticipant& participant, const GuidPrefix& of) {
    return const_cast<RemoteParticipant&>(participant.remote_participants().all().at(of));
  }
  static ParticipantCore& core(RtpsParticipant& participant) {
    return const_cast<ParticipantCore&>(participant.remote_participants().core());
  }
};

}  // namespace ddssec::rtps::testing
