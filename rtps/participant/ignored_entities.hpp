// The entities that the application ignores permanently (DDS 1.4, 2.2.2.2.1.14 to 2.2.2.2.1.17).
#pragma once

#include <set>
#include <string>

#include "rtps/discovery/endpoint_data.hpp"

namespace ddssec::rtps {

/// The ignored participants, topics and endpoints of one participant. Entries are never removed.
class IgnoredEntities {
 public:
  // All return false if the entity was already ignored.
  bool add_participant(const GuidPrefix& prefix) { return participants_.insert(prefix).second; }
  bool add_endpoint(const Guid& guid) { return endpoints_.insert(guid).second; }
  bool add_topic(const std::string& name) { return topics_.insert(name).second; }

  bool contains(const GuidPrefix& participant) const { return participants_.contains(participant); }
  /// True if the endpoint, its participant or its topic is ignored.
  bool contains(const EndpointData& data) const {
    return participants_.contains(data.guid.prefix) || endpoints_.contains(data.guid) ||
           topics_.contains(data.topic_name);
  }

 private:
  std::set<GuidPrefix> participants_;
  std::set<Guid> endpoints_;
  std::set<std::string> topics_;
};

}  // namespace ddssec::rtps
