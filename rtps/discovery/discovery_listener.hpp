// The interface that receives the results of discovery: the contents of the builtin topics (DDS
// 1.4, 2.2.5).
#pragma once

#include "rtps/discovery/endpoint_data.hpp"
#include "rtps/discovery/participant_data.hpp"

namespace ddssec::rtps {

/// Receives remote participants and their endpoints once they are accepted. A secured participant
/// accepts those that are authenticated, or admitted without authentication. Called from within
/// receive and tick.
class DiscoveryListener {
 public:
  virtual ~DiscoveryListener() = default;
  /// Also called when the participant announces changed data.
  virtual void on_participant(const ParticipantData& data) = 0;
  virtual void on_participant_gone(const Guid& guid) = 0;
  virtual void on_endpoint(const EndpointData& data) = 0;
  virtual void on_endpoint_gone(const EndpointData& data) = 0;
};

}  // namespace ddssec::rtps
