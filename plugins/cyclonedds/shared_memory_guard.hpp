// Refuses protected endpoints whose samples Cyclone DDS would pass through shared memory. On that
// path it asks no plugin, and the samples are not protected (docs/decisions).
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "plugins/spi/access_control.hpp"

namespace ddssec::cyclonedds {

/// A way in which samples would leave this process without the plugins.
struct Bypass {
  std::string_view setting;  ///< setting in Cyclone DDS's configuration
  std::string seen;          ///< the evidence that it is active
};

/// Returns the path of an iceoryx segment among the mappings of a process, in the format of
/// /proc/PID/maps; empty if there is none.
std::optional<std::string> iceoryx_segment(std::string_view mappings);

/// Returns the way in which samples of Cyclone DDS would bypass the plugins in this process; empty
/// if they cannot. In 0.10, the process maps iceoryx's management segment once a domain enables
/// shared memory. In 11, the library of a PSMX instance is loaded and exports TYPE_create_psmx.
/// Error: shared_memory_undecidable, if /proc/self/maps (or the given file) cannot be read.
Result<std::optional<Bypass>> find_bypass(const char* mappings_file = "/proc/self/maps");

/// The direction of a local endpoint. The access control of the opposite direction counts.
enum class EndpointDirection : std::uint8_t { writes, reads };

/// Returns the protection of the endpoint's samples that governance demands and shared memory would
/// not provide, such as "data_protection_kind ENCRYPT"; empty if there is none.
std::string promise_for_samples(const spi::ParticipantSecurityAttributes& participant,
                                const spi::EndpointSecurityAttributes& endpoint,
                                EndpointDirection direction);

/// The check for one domain. Cyclone DDS sets up shared memory with the domain, before it loads a
/// plugin. So one probe is enough; it is made for the first endpoint that needs it. Thread-safe.
class SharedMemoryGuard {
 public:
  using Probe = std::function<Result<std::optional<Bypass>>()>;
  explicit SharedMemoryGuard(Probe probe) : probe_(std::move(probe)) {}

  /// Returns the value of org.ddssec.access.allow_shared_memory; false if it is missing. Error:
  /// invalid_property.
  static Result<bool> is_allowed_by(const spi::PropertyList& properties);

  /// Notes that the participant accepts shared memory for all its endpoints.
  void allow(spi::PermissionsHandle participant);
  bool is_allowed(spi::PermissionsHandle participant) const;
  void forget(spi::PermissionsHandle participant);

  /// Success if the samples cannot bypass the plugins. `promise` must not be empty. Errors:
  /// shared_memory_bypasses_protection, shared_memory_undecidable.
  Status check(std::string_view topic, std::string_view promise);

 private:
  Result<std::optional<Bypass>> bypass();

  const Probe probe_;
  mutable std::mutex mutex_;
  std::set<std::int64_t> allowed_;
  std::optional<std::optional<Bypass>> known_;  ///< result of a successful probe
};

}  // namespace ddssec::cyclonedds
