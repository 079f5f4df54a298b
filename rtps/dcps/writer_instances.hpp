// The instances a DataWriter registered, and when each must be written again (DDS 1.4, 2.2.2.4.2).
// No I/O, clock or lock.
#pragma once

#include <functional>
#include <map>

#include "base/clock.hpp"
#include "rtps/dcps/link.hpp"
#include "rtps/dcps/states.hpp"
#include "rtps/qos/qos.hpp"

namespace ddssec::rtps {

class WriterInstances {
 public:
  /// Where RESOURCE_LIMITS.max_instances says "unlimited".
  static constexpr std::size_t kMostInstances = 65536;

  explicit WriterInstances(const Qos& qos);

  /// The instance's handle; registered if it was not. HANDLE_NIL: there are too many.
  InstanceHandle enter(const KeyHash& key, const std::function<Bytes()>& serialized_key);
  /// HANDLE_NIL if it is not registered.
  InstanceHandle lookup(const KeyHash& key) const;
  /// nullptr for an unknown instance.
  const Bytes* key_value(InstanceHandle instance) const;
  void remove(const KeyHash& key);
  std::size_t size() const { return by_key_.size(); }
  /// Of all: the key hash and the serialized key.
  std::vector<std::pair<KeyHash, Bytes>> keys() const;

  /// The instance was written at `now`: its DEADLINE starts again.
  void written(const KeyHash& key, MonotonicTime now);
  /// Nothing is expected of it until it is written again.
  void disposed(const KeyHash& key);
  void check_deadlines(MonotonicTime now, const std::function<void(InstanceHandle)>& missed);
  MonotonicTime next_deadline() const;
  void set_deadline(Duration period, MonotonicTime now);

 private:
  struct Instance {
    InstanceHandle handle;
    Bytes key_value;
    MonotonicTime deadline = kNever;
    Link<Instance> due{this};
  };

  const std::size_t most_;
  MonotonicTime deadline_ = kNever;  ///< period
  LinkedList<Instance> due_;         ///< in the order of deadlines; outlives the instances
  std::map<KeyHash, Instance> by_key_;
  std::map<InstanceHandle, const Instance*> by_handle_;
  std::uint64_t next_handle_ = 1;
};

}  // namespace ddssec::rtps
