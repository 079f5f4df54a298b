// The endpoints of applications, and whether renewed permissions still allow them. The core does
// not judge again what it has matched, and peers learn of renewed permissions only in a new
// handshake. So authentication ends the participant's sessions if a right of an endpoint is lost,
// or if an endpoint has a right that peers do not know
// (AuthenticationAdapter::note_changed_rights).
#pragma once

#include <chrono>
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
  using Duration = std::chrono::nanoseconds;

  void add(Place place, spi::PermissionsHandle local, bool writes,
           const spi::EndpointRequest& request);
  void remove(Place place);
  /// Forgets a local participant whose permissions the host returns.
  void forget(spi::PermissionsHandle local);

  /// Judges the endpoints of a local participant by its permissions, if those were renewed since
  /// the last call. Returns own_rights_lost if they no longer allow an endpoint that was allowed
  /// before. Otherwise returns own_rights_gained if peers do not know a right of an endpoint, but
  /// not after a loss by the same renewal. Each renewal causes at most one of the two errors: the
  /// sessions that begin afterwards have presented these permissions, and to end them again would
  /// change nothing.
  std::optional<Error> poll(spi::PermissionsHandle local, spi::AccessControl& plugin, Duration now);
  /// Returns the number of times that `poll` has returned an error for that participant.
  std::uint64_t changes(spi::PermissionsHandle local) const;

 private:
  struct Endpoint {
    spi::PermissionsHandle local;
    bool writes;
    std::string topic;
    std::vector<std::string> partitions;
    spi::PropertyList data_tags;
    std::uint64_t judged = 0;  ///< the number of renewals of the permissions by which it was judged
    bool is_allowed = true;
    /// When it was last asked for these permissions whether peers know the right, and the time to
    /// the next question.
    std::optional<Duration> asked = {};
    Duration pause{};
  };
  struct Changes {
    std::uint64_t count = 0;
    std::uint64_t renewals = 0;  ///< of the permissions that caused the last one
  };
  struct Request;
  static void note_asked(Endpoint& endpoint, Duration now);
  static bool is_due(const Endpoint& endpoint, Duration now);
  std::optional<Error> find_lost(spi::PermissionsHandle local, std::uint64_t renewals,
                                 spi::AccessControl& plugin);
  /// Returns an endpoint with a right that peers do not know; nullptr if there is none.
  const Endpoint* find_gained(spi::PermissionsHandle local, spi::AccessControl& plugin,
                              Duration now);

  mutable std::mutex mutex_;
  std::map<Place, Endpoint> endpoints_;
  std::map<spi::PermissionsHandle, Changes> changes_;
};

}  // namespace ddssec::cyclonedds
