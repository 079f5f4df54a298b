// Finds the local endpoints for arriving messages.
#pragma once

#include "rtps/participant/endpoint_lookup.hpp"
#include "rtps/participant/local_endpoints.hpp"
#include "rtps/participant/remote_participants.hpp"

namespace ddssec::rtps {

/// The EndpointLookup of a participant: the builtin endpoints and those of the application.
class EndpointDirectory final : public EndpointLookup {
 public:
  EndpointDirectory(ParticipantCore& core, LocalEndpoints& local, RemoteParticipants& remotes)
      : core_(core), local_(local), remotes_(remotes) {}

  std::span<StatefulReader* const> readers_of(const Guid& writer) override;
  StatefulWriter* writer_for(const EntityId& writer, const GuidPrefix& reader) override;
  bool sends_keys(const GuidPrefix& participant) override;
  bool marks_ends(const GuidPrefix& participant) override;

 private:
  ParticipantCore& core_;
  LocalEndpoints& local_;
  RemoteParticipants& remotes_;
  StatefulReader* volatile_reader_ = nullptr;  ///< that of the peer that was looked up last
};

}  // namespace ddssec::rtps
