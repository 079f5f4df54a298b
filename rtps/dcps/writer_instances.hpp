// The instances that a DataWriter registered, and the deadline of each (DDS 1.4, 2.2.2.4.2). No
// I/O, clock or lock.
#pragma once

#include <functional>
#include <map>

#include "base/clock.hpp"
#include "rtps/dcps/link.hpp"
#include "rtps/dcps/states.hpp"
#include "rtps/qos/qos.hpp"

namespace ddssec::rtps {

/// The registered instances of one DataWriter.
class WriterInstances {
 public:
  /// The limit that applies if RESOURCE_LIMITS.max_instances is "unlimited".
  static constexpr std::size_t kMaxInstances = 65536;

  explicit WriterInstances(const Qos& qos);

  /// Returns the instance's handle, and registers the instance if needed. Returns HANDLE_NIL if the
  /// limit is reached.
  InstanceHandle enter(const KeyHash& key, const std::function<Bytes()>& serialized_key);
  /// Returns HANDLE_NIL if the instance is not registered.
  InstanceHandle lookup(const KeyHash& key) const;
  /// Returns nullptr if the instance is not known.
  const Bytes* key_value(InstanceHandle instance) const;
  /// Forgets the instance, if it is registered, and its deadline.
  void remove(const KeyHash& key);
  /// Returns the number of registered instances.
  std::size_t size() const { return by_key_.size(); }
  /// Returns the key hash and the serialized key of each instance.
  std::vector<std::pair<KeyHash, Bytes>> keys() const;

  /// Notes that the instance was written at `now`: its DEADLINE period starts again.
  void note_written(const KeyHash& key, MonotonicTime now);
  /// Notes that the instance was disposed: it has no deadline until it is written again.
  void note_disposed(const KeyHash& key);
  /// Calls `missed` for each instance whose deadline has passed, earliest first. The next period of
  /// such an instance begins at `now`, so it is reported once in each period.
  void expire_deadlines(MonotonicTime now, const std::function<void(InstanceHandle)>& missed);
  /// Returns the earliest deadline; kNever if there is none.
  MonotonicTime next_deadline() const;
  /// Changes the DEADLINE period. The new period of each instance begins at `now`.
  void set_deadline(Duration period, MonotonicTime now);

 private:
  struct Instance {
    InstanceHandle handle;
    Bytes key_value;
    MonotonicTime deadline = kNever;
    Link<Instance> due{this};
  };

  const std::size_t max_;
  MonotonicTime deadline_ = kNever;  ///< the DEADLINE period
  LinkedList<Instance> due_;         ///< in the order of deadlines; must outlive the instances
  std::map<KeyHash, Instance> by_key_;
  std::map<InstanceHandle, const Instance*> by_handle_;
  std::uint64_t next_handle_ = 1;
};

}  // namespace ddssec::rtps
