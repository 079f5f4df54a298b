// Conditions that a WaitSet waits for (DDS 1.4, 2.2.2.1.7 to 2.2.2.1.9, 2.2.2.5.8).
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "rtps/dcps/query_matches.hpp"
#include "rtps/dcps/status.hpp"

namespace ddssec::rtps {

class AnyDataReader;
class Entity;
class ServingTurn;
struct ConditionState;

/// An object with a trigger value. Its destructor detaches it from all wait sets. Thread-safe. It
/// may be destroyed while a wait set is destroyed, but not while it is being attached or detached.
class Condition {
 public:
  virtual ~Condition();
  Condition(const Condition&) = delete;
  Condition& operator=(const Condition&) = delete;

  /// True while it is triggered.
  bool trigger_value() const;

 protected:
  /// `turn` is that of the participant whose entity triggers the condition; empty if the
  /// application triggers it.
  explicit Condition(std::shared_ptr<ServingTurn> turn);
  /// Sets the trigger value. If it is true, wakes the threads that wait for it.
  void trigger(bool value);
  const std::shared_ptr<ServingTurn>& turn() const;

 private:
  friend class WaitSet;
  const std::shared_ptr<ConditionState> state_;
};

/// A condition that the application creates, owns and triggers.
class GuardCondition final : public Condition {
 public:
  /// Creates a condition that is not triggered.
  GuardCondition() : Condition(nullptr) {}

  /// Sets the trigger value. If it is true, wakes the threads that wait for it. It stays triggered
  /// until it is set to false. May be called by any thread.
  void set_trigger_value(bool value) { trigger(value); }
};

/// A condition that is triggered while one of the enabled communication statuses of its entity has
/// changed and has not been read. All statuses are enabled at first. Its entity creates and owns
/// it.
class StatusCondition final : public Condition {
 public:
  /// Returns the entity that owns the condition.
  Entity& entity() const { return entity_; }
  /// Returns the statuses that trigger it.
  StatusMask enabled_statuses() const { return StatusMask::from(enabled_); }
  /// Sets the statuses that trigger it. Statuses that have already changed count as well.
  void set_enabled_statuses(StatusMask statuses);

 private:
  friend class ReadCondition;
  friend class StatusChanges;
  StatusCondition(Entity& entity, std::shared_ptr<ServingTurn> turn)
      : Condition(std::move(turn)), entity_(entity) {}
  void update();

  Entity& entity_;
  std::atomic<std::uint32_t> enabled_ = kAnyStatus.bits;
};

/// A condition that is triggered while its reader holds samples in these states. The reader creates
/// and deletes it.
class ReadCondition : public Condition {
 public:
  /// Returns the reader that owns the condition.
  AnyDataReader& datareader() const { return reader_; }
  /// Returns the states for which it was created.
  const States& states() const { return states_; }
  /// Succeeds if the condition belongs to this reader. Errors: rtps_precondition_not_met.
  Status check_reader(const AnyDataReader& reader) const;

 protected:
  friend class ReadConditions;
  ReadCondition(AnyDataReader& reader, const States& states);

  AnyDataReader& reader_;
  const States states_;
  std::unique_ptr<QueryMatches> query_;

 private:
  template <class Reader, class... Collections>
  friend class SampleAccess;
  /// Returns nullptr if this is not a QueryCondition, or if its expression is empty.
  const QueryMatches* query() const { return query_.get(); }
};

/// A condition that is triggered while its reader holds samples in these states that match a query.
/// Samples without data match no query (DDS 1.4, 2.2.2.5.9).
class QueryCondition final : public ReadCondition {
 public:
  const std::string& query_expression() const { return text_.expression; }
  /// Returns the values of %0, %1 and so on in the expression.
  std::vector<std::string> query_parameters() const;
  /// Sets the values of the parameters. They apply at once, also to the samples that the reader
  /// holds. Errors: rtps_filter_invalid; then nothing has changed.
  Status set_query_parameters(std::vector<std::string> parameters);

 private:
  friend class AnyDataReader;
  friend class ReadConditions;
  QueryCondition(AnyDataReader& reader, const States& states, FilterText text,
                 std::unique_ptr<QueryMatches> query)
      : ReadCondition(reader, states), text_(std::move(text)) {
    query_ = std::move(query);
  }

  FilterText text_;
};

}  // namespace ddssec::rtps
