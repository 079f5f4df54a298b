// Refuses protected endpoints whose samples Cyclone DDS would pass through shared memory: on that
// way it asks no plugin, and the samples lie in the clear (DECISIONS.md).
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

/// How samples would leave this process without the plugins being asked.
struct Bypass {
  std::string_view setting;  ///< of Cyclone DDS's configuration
  std::string seen;          ///< what gives it away
};

/// The path of an iceoryx segment among the mappings of a process, in the form of /proc/PID/maps.
std::optional<std::string> iceoryx_segment(std::string_view mappings);

/// How samples of Cyclone DDS would bypass the plugins in this process; nothing: they cannot.
/// 0.10: the process has iceoryx's management segment mapped once a domain enables shared memory.
/// 11: the library of a PSMX instance is loaded and exports TYPE_create_psmx.
/// Error: shared_memory_undecidable, if /proc/self/maps (or the file given) cannot be read.
Result<std::optional<Bypass>> find_bypass(const char* mappings_file = "/proc/self/maps");

/// Whether a local endpoint writes or reads: the other side's access control is what counts.
enum class Direction : std::uint8_t { writes, reads };

/// What governance promises about the endpoint's samples and shared memory would not keep, as
/// "data_protection_kind ENCRYPT"; empty: nothing.
std::string promise_for_samples(const spi::ParticipantSecurityAttributes& participant,
                                const spi::EndpointSecurityAttributes& endpoint,
                                Direction direction);

/// One for each domain. Cyclone DDS sets up shared memory with the domain, before it loads a
/// plugin: one look is enough, and is taken at the first endpoint that needs it. Thread-safe.
class SharedMemoryGuard {
 public:
  using Probe = std::function<Result<std::optional<Bypass>>()>;
  explicit SharedMemoryGuard(Probe probe) : probe_(std::move(probe)) {}

  /// What org.ddssec.access.allow_shared_memory says; false without it. Error: invalid_property.
  static Result<bool> is_allowed_by(const spi::PropertyList& properties);

  /// The participant accepts shared memory for all its endpoints.
  void allow(spi::PermissionsHandle participant);
  bool is_allowed(spi::PermissionsHandle participant) const;
  void forget(spi::PermissionsHandle participant);

  /// Success if the samples cannot bypass the plugins. `promise` is not empty. Errors:
  /// shared_memory_bypasses_protection, shared_memory_undecidable.
  Status check(std::string_view topic, std::string_view promise);

 private:
  Result<std::optional<Bypass>> bypass();

  const Probe probe_;
  mutable std::mutex mutex_;
  std::set<std::int64_t> allowed_;
  std::optional<std::optional<Bypass>> known_;  ///< after a look that succeeded
};

}  // namespace ddssec::cyclonedds
