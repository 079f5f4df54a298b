// The writers of a reader that have an instance: they wrote it and have not unregistered it.
#pragma once

#include <map>
#include <set>
#include <vector>

#include "base/ids.hpp"
#include "rtps/dcps/held_shares.hpp"
#include "rtps/dcps/status.hpp"

namespace ddssec::rtps {

/// The instances of each writer, so that removing a writer costs time only for its own instances.
/// No identity gets more of the places than are free.
class InstanceWriters {
 public:
  static constexpr std::size_t kMax = 524288;

  /// True if the writer may have the instance, or has it. `share` is that of the writer's identity.
  bool has_room(const Guid& writer, InstanceHandle instance, const HeldShareOf& share) const;
  /// Notes that the writer has the instance. Returns false if it has it already.
  bool add(const Guid& writer, InstanceHandle instance, const HeldShareOf& share);
  /// Notes that the writer no longer has the instance. Returns false if it did not have it.
  bool remove(const Guid& writer, InstanceHandle instance);
  std::vector<InstanceHandle> instances_of(const Guid& writer) const;
  /// Returns the share of a writer that has an instance.
  const HeldShareOf& share_of(const Guid& writer) const { return writers_.at(writer).share; }
  std::size_t size() const { return size_; }

 private:
  struct Writer {
    std::set<InstanceHandle> instances;
    HeldShareOf share;
  };
  bool contains(const Guid& writer, InstanceHandle instance) const;

  std::map<Guid, Writer> writers_;
  std::size_t size_ = 0;
};

}  // namespace ddssec::rtps
