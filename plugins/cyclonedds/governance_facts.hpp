// State of local participants in access control: facts about their governance, for authentication,
// and whether they are cut off.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "base/result.hpp"
#include "plugins/spi/attributes.hpp"
#include "plugins/spi/handles.hpp"

namespace ddssec::cyclonedds {

/// Bits of a mask that one library passes to another (abi.hpp).
enum class GovernanceFact : std::uint32_t {
  allows_unauthenticated = 1,
  cut_off = 2,  ///< not about the governance: the participant's permissions have ended
};
constexpr bool has(std::uint32_t facts, GovernanceFact fact) {
  return (facts & static_cast<std::uint32_t>(fact)) != 0;
}

/// The facts, by the permissions handles of local participants. Thread-safe.
class GovernanceFacts {
 public:
  void note(spi::PermissionsHandle permissions, spi::IdentityHandle local,
            const spi::ParticipantSecurityAttributes& attributes) {
    std::uint32_t facts = 0;
    const auto add = [&](bool holds, GovernanceFact fact) {
      if (holds) facts |= static_cast<std::uint32_t>(fact);
    };
    add(attributes.allow_unauthenticated_participants, GovernanceFact::allows_unauthenticated);
    const std::lock_guard lock(mutex_);
    locals_[permissions] = {.local = local, .facts = facts};
  }
  void forget(spi::PermissionsHandle permissions) {
    const std::lock_guard lock(mutex_);
    locals_.erase(permissions);
  }
  /// The longest time that the host takes to finish creating a participant.
  static constexpr std::chrono::seconds kCreation{1};

  /// Notes that the host creates the participant. Error: unauthenticated_peers_need_own_process if
  /// it or another participant of this domain of the process admits unauthenticated participants.
  /// `shows_none` is true if the host shows no participant of this domain. Those that it began to
  /// create at least kCreation ago are then being deleted, and do not count.
  ///
  /// The core has one security state of a remote participant for all local ones. If a handshake of
  /// one that admits unauthenticated participants fails, the core removes that state. The
  /// handshakes of the others then use it through a null pointer. The core also lets a handshake
  /// fail by itself, so no answer of a plugin prevents that.
  Status join(spi::PermissionsHandle permissions, std::chrono::nanoseconds now, bool shows_none) {
    const std::lock_guard lock(mutex_);
    const auto own = locals_.find(permissions);
    if (own == locals_.end()) return {};
    for (const auto& [other, known] : locals_) {
      if (other == permissions || !known.joined) continue;
      if (shows_none && now - *known.joined >= kCreation) continue;
      if (has(known.facts | own->second.facts, GovernanceFact::allows_unauthenticated))
        return fail(Code::unauthenticated_peers_need_own_process,
                    {.document = "governance",
                     .field = "allow_unauthenticated_participants",
                     .expected = "false, or one participant of the domain in the process",
                     .found = "true, and another participant"});
    }
    own->second.joined = now;
    return {};
  }
  /// Returns the permissions handle of a local participant.
  std::optional<spi::PermissionsHandle> permissions_of(spi::IdentityHandle local) const {
    const std::lock_guard lock(mutex_);
    for (const auto& [permissions, known] : locals_)
      if (known.local == local) return permissions;
    return std::nullopt;
  }
  /// Returns the permissions handles of all local participants.
  std::vector<spi::PermissionsHandle> locals() const {
    const std::lock_guard lock(mutex_);
    std::vector<spi::PermissionsHandle> out;
    for (const auto& [permissions, known] : locals_) out.push_back(permissions);
    return out;
  }
  /// Returns the facts of a local participant; 0 if they are unknown, or if there are none.
  std::uint32_t of(spi::IdentityHandle local) const {
    const std::lock_guard lock(mutex_);
    for (const auto& [permissions, known] : locals_)
      if (known.local == local)
        return known.facts |
               (known.cut_off ? static_cast<std::uint32_t>(GovernanceFact::cut_off) : 0);
    return 0;
  }
  /// Returns the local identity with these permissions; empty if they belong to a peer.
  std::optional<spi::IdentityHandle> identity_of(spi::PermissionsHandle permissions) const {
    const std::lock_guard lock(mutex_);
    const auto known = locals_.find(permissions);
    return known == locals_.end() ? std::nullopt : std::optional(known->second.local);
  }

  /// Makes `check` refuse the participant for that reason. A second reason is ignored.
  void cut_off(spi::IdentityHandle local, Code reason) {
    const std::lock_guard lock(mutex_);
    for (auto& [permissions, known] : locals_)
      if (known.local == local && !known.cut_off) known.cut_off = reason;
  }
  /// True if this domain of the process has another local participant that is not cut off.
  bool has_others(spi::IdentityHandle local) const {
    const std::lock_guard lock(mutex_);
    for (const auto& [permissions, known] : locals_)
      if (known.local != local && !known.cut_off) return true;
    return false;
  }
  /// Success unless the participant is cut off; the error is the reason.
  Status check(spi::PermissionsHandle permissions) const {
    const std::lock_guard lock(mutex_);
    const auto known = locals_.find(permissions);
    return known == locals_.end() ? Status() : known->second.status();
  }
  Status check(spi::IdentityHandle local) const {
    const std::lock_guard lock(mutex_);
    for (const auto& [permissions, known] : locals_)
      if (known.local == local) return known.status();
    return {};
  }

 private:
  struct KnownFacts {
    spi::IdentityHandle local;
    std::uint32_t facts;
    std::optional<Code> cut_off = {};
    std::optional<std::chrono::nanoseconds> joined = {};
    Status status() const { return cut_off ? Status(fail(*cut_off)) : Status(); }
  };

  mutable std::mutex mutex_;
  std::map<spi::PermissionsHandle, KnownFacts> locals_;
};

}  // namespace ddssec::cyclonedds
