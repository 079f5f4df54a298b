// Conditions that a WaitSet waits for (DDS 1.4, 2.2.2.1.7 to 2.2.2.1.9, 2.2.2.5.8).
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "rtps/dcps/status.hpp"

namespace ddssec::rtps {

class AnyDataReader;
class Entity;
struct WaitSetState;

/// Has a trigger value. Leaves the wait sets it is attached to when it dies. Thread-safe.
class Condition {
 public:
  Condition() = default;
  virtual ~Condition();
  Condition(const Condition&) = delete;
  Condition& operator=(const Condition&) = delete;

  bool trigger_value() const { return trigger_; }

 protected:
  void trigger(bool value);

 private:
  friend class WaitSet;
  std::atomic<bool> trigger_ = false;
  std::mutex mutex_;
  std::vector<std::shared_ptr<WaitSetState>> sets_;
};

/// Triggered by the application.
class GuardCondition final : public Condition {
 public:
  void set_trigger_value(bool value) { trigger(value); }
};

/// Triggered by any of the enabled communication statuses of its entity; all are enabled at first.
class StatusCondition final : public Condition {
 public:
  explicit StatusCondition(Entity& entity) : entity_(entity) {}

  Entity& entity() const { return entity_; }
  StatusMask enabled_statuses() const { return StatusMask::from(enabled_); }
  void set_enabled_statuses(StatusMask statuses);

 private:
  friend class Entity;
  void update();

  Entity& entity_;
  std::atomic<std::uint32_t> enabled_ = kAnyStatus.bits;
};

/// Triggered while its reader holds samples in these states. The reader makes and deletes it.
class ReadCondition final : public Condition {
 public:
  AnyDataReader& datareader() const { return reader_; }
  const States& states() const { return states_; }

 private:
  friend class AnyDataReader;
  ReadCondition(AnyDataReader& reader, const States& states) : reader_(reader), states_(states) {}

  AnyDataReader& reader_;
  const States states_;
};

}  // namespace ddssec::rtps
