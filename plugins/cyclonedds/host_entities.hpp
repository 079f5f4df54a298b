// Access to the host's entities by its public functions. libddsc may have been loaded without
// RTLD_GLOBAL, and the plugin is not linked with it. So its functions are looked up in the library
// that contains the host's code.
#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <vector>

#include "base/ids.hpp"

namespace ddssec::cyclonedds {

/// Finds a function that the host's library or any other library of the process exports; nullptr if
/// there is none. `code` is an address in the host's code, or null.
void* find_host_symbol(const void* code, const char* name) noexcept;

/// The host's entities. The functions take locks of entities, so only threads that are not inside a
/// call of the host may use them.
class HostEntities {
 public:
  virtual ~HostEntities() = default;

  struct Participant {
    std::int32_t handle = 0;
    Guid guid = {};
    std::set<Guid> entities = {};  ///< all entities below it; some may be just being deleted
  };
  /// Returns all participants of the process. Waits for entities that are being created, together
  /// with their parents.
  virtual std::vector<Participant> participants() const = 0;

  /// Makes the host announce a reader of kCarrierTopic whose USER_DATA is the GUID `ended`, then
  /// deletes it. False if the host refuses, for example when the participant is being deleted.
  virtual bool carry_end(const Participant& participant, const Guid& ended) const = 0;
};

/// False only if the host shows no participant of the domain: it has none, or is creating or
/// deleting those that it has. Takes only the locks of the process's list of domains and of the
/// domain, so a call of the host that creates a participant may use it.
bool may_have_participants(const void* code, std::uint32_t domain_id) noexcept;

/// Returns access to the host; nullptr if the host lacks a needed function.
std::unique_ptr<HostEntities> find_host_entities(const void* code);

}  // namespace ddssec::cyclonedds
