// The host's entities by its public functions. libddsc may have been loaded without RTLD_GLOBAL,
// and nothing of it is linked: its functions are looked up where the host's code lies.
#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <vector>

#include "base/ids.hpp"

namespace ddssec::cyclonedds {

/// A function that the host's library exports, or any library of the process; null: none does.
/// `code` is an address in the host's code, or null.
void* find_host_symbol(const void* code, const char* name) noexcept;

/// Any thread that is not in a call of the host's: they take the locks of entities.
class HostEntities {
 public:
  virtual ~HostEntities() = default;

  struct Participant {
    std::int32_t handle = 0;
    Guid guid = {};
    std::set<Guid> entities = {};  ///< all below it, of which some may be just leaving
  };
  /// All participants of the process. Who is being created, together with its parent, is waited
  /// for.
  virtual std::vector<Participant> participants() const = 0;

  /// Makes the host announce a reader of kCarrierTopic whose USER_DATA is the GUID `ended`, and
  /// deletes it. False: the host refused, as when the participant leaves.
  virtual bool carry_end(const Participant& participant, const Guid& ended) const = 0;
};

/// Null: the host has not all the functions that are needed.
std::unique_ptr<HostEntities> find_host_entities(const void* code);

}  // namespace ddssec::cyclonedds
