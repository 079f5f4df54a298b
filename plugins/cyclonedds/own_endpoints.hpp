// The endpoints of applications, and whether renewed permissions still allow them. The core does
// not judge again what it has matched. If a right of an endpoint is lost, authentication ends the
// participant's sessions (AuthenticationAdapter::note_lost_rights).
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "plugins/spi/access_control.hpp"

namespace ddssec::cyclonedds {

/// The endpoints of the local participants of one domain. Thread-safe.
class OwnEndpoints {
 public:
  /// The place where the host keeps the attributes of an endpoint, for as long as the endpoint
  /// exists.
  using Place = const void*;

  void add(Place place, spi::PermissionsHandle local, bool writes,
           const spi::EndpointRequest& request);
  void remove(Place place);
  /// Forgets a local participant whose permissions the host returns.
  void forget(spi::PermissionsHandle local);

  /// Judges the endpoints of a local participant by its permissions, if those were renewed since
  /// the last call. Returns own_rights_lost if they no longer allow an endpoint that was allowed
  /// before.
  std::optional<Error> poll(spi::PermissionsHandle local, spi::AccessControl& plugin);
  /// Returns the number of times that `poll` has returned an error for that participant.
  std::uint64_t losses(spi::PermissionsHandle local) const;

 private:
  struct Endpoint {
    spi::PermissionsHandle local;
    bool writes;
    std::string topic;
    std::vector<std::string> partitions;
    spi::PropertyList data_tags;
    std::uint64_t judged = 0;  ///< the number of renewals of the permissions by which it was judged
    bool is_allowed = true;
  };
  static Status ask(const Endpoint& endpoint, spi::AccessControl& plugin);

  mutable std::mutex mutex_;
  std::map<Place, Endpoint> endpoints_;
  std::map<spi::PermissionsHandle, std::uint64_t> losses_;
};

}  // namespace ddssec::cyclonedds
