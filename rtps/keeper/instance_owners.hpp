// OWNERSHIP EXCLUSIVE of a kept topic (DDS 1.4, 2.2.3.9): the writer that owns each instance. No
// I/O, clock or lock.
#pragma once

#include <map>
#include <optional>
#include <set>

#include "base/clock.hpp"
#include "base/ids.hpp"
#include "rtps/dcps/ended_instances.hpp"

namespace ddssec::rtps {

/// Decides as a reader does. An instance belongs to its strongest living writer; if several are
/// equally strong, to the one with the lowest GUID. The owner keeps an instance that it disposes,
/// until it unregisters it or is no longer alive.
class InstanceOwners {
 public:
  /// The limit for owned instances. No identity may own more of them than are free, so there is
  /// always room for another identity.
  static constexpr std::size_t kMaxInstances = 131072;

  /// Until `expects_until`, owners that are only expected count as alive.
  explicit InstanceOwners(MonotonicTime expects_until) : expects_until_(expects_until) {}

  /// Adds a matched writer, or changes its OWNERSHIP_STRENGTH. Its instances use the share of
  /// `identity`; if it is empty, no share applies.
  void set_writer(const Guid& writer, std::int32_t strength,
                  const std::optional<GuidPrefix>& identity);
  void remove_writer(const Guid& writer);
  /// Notes that the writer's lease ended: it owns nothing until it writes again.
  void note_lease_ended(const Guid& writer);
  /// Notes that the stored instance was last written by this writer, which may still be alive. Must
  /// be called before all others. If there is no room, the writer is not expected.
  void expect(const KeyHash& instance, const Guid& writer);

  enum class Claim : std::uint8_t {
    owned,    ///< the writer owns it now
    refused,  ///< a stronger living writer owns it
    later,    ///< the expected owner may still come back
    no_room,  ///< the share of the writer's identity is used up
  };
  /// Handles a sample of the instance by the writer.
  Claim claim(const KeyHash& instance, const Guid& writer, MonotonicTime now);
  /// Notes that the writer unregistered the instance.
  void release(const KeyHash& instance, const Guid& writer);

  std::size_t size() const { return owners_.size(); }

 private:
  struct Writer {
    std::int32_t strength = 0;
    std::optional<GuidPrefix> identity;
  };
  using Owners = std::map<KeyHash, Guid>;

  bool is_stronger(const Guid& writer, const Guid& owner) const;
  /// True if the writer may own one more instance. `replaced` is an owner that loses an instance to
  /// it.
  bool has_room(const Guid& writer, const Guid* replaced = nullptr) const;
  std::optional<GuidPrefix> identity_of(const Guid& writer) const;
  void enter(const KeyHash& instance, const Guid& writer);
  void leave(Owners::iterator at);

  const MonotonicTime expects_until_;
  std::map<Guid, Writer> writers_;
  Owners owners_;
  std::set<std::pair<Guid, KeyHash>> owned_;       ///< the same by owner
  std::map<GuidPrefix, std::size_t> of_identity_;  ///< number of instances, for matched writers
};

}  // namespace ddssec::rtps
