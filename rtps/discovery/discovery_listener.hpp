// What an observer of discovery is told: the content of the builtin topics (DDS 1.4, 2.2.5).
#pragma once

#include "rtps/discovery/endpoint_data.hpp"
#include "rtps/discovery/participant_data.hpp"

namespace ddssec::rtps {

/// Remote participants and their endpoints, if they were accepted: in a secured participant
/// authenticated, or admitted without. Called from within receive and tick.
class DiscoveryListener {
 public:
  virtual ~DiscoveryListener() = default;
  /// Also when it announces something else than before.
  virtual void on_participant(const ParticipantData& data) = 0;
  virtual void on_participant_gone(const Guid& guid) = 0;
  virtual void on_endpoint(const EndpointData& data) = 0;
  virtual void on_endpoint_gone(const EndpointData& data) = 0;
};

}  // namespace ddssec::rtps
