#include "rtps/dcps/condition.hpp"

#include "rtps/dcps/condition_state.hpp"
#include "rtps/dcps/data_reader.hpp"

namespace ddssec::rtps {

Condition::Condition(std::shared_ptr<ServingTurn> turn)
    : state_(std::make_shared<ConditionState>(std::move(turn))) {}

bool Condition::trigger_value() const { return state_->trigger; }

const std::shared_ptr<ServingTurn>& Condition::turn() const { return state_->turn; }

// Only trigger() holds both mutexes, and it locks that of the condition first. Every other function
// empties its own list before it removes itself from the lists of the others.
Condition::~Condition() {
  std::vector<std::shared_ptr<WaitSetState>> sets;
  {
    const std::lock_guard lock(state_->mutex);
    sets.swap(state_->sets);
  }
  for (const auto& set : sets) {
    const std::lock_guard lock(set->mutex);
    std::erase_if(set->conditions, [this](const auto& one) { return one.condition == this; });
  }
}

// The value is set before the wait set's mutex is locked, so that no waiting thread misses it.
void Condition::trigger(bool value) {
  const bool was = state_->trigger.exchange(value);
  if (was || !value) return;
  const std::lock_guard lock(state_->mutex);
  for (const auto& set : state_->sets) set->notify();
}

void StatusCondition::update() {
  trigger(!(entity_.changes_.all() & StatusMask::from(enabled_)).empty());
}

void StatusCondition::set_enabled_statuses(StatusMask statuses) {
  const auto held = entity_.lock();
  enabled_ = statuses.bits;
  update();
}

ReadCondition::ReadCondition(AnyDataReader& reader, const States& states)
    : Condition(reader.status_condition().turn()), reader_(reader), states_(states) {}

Status ReadCondition::check_reader(const AnyDataReader& reader) const {
  if (&reader_ == &reader) return {};
  return precondition_not_met_error("read condition", "one of this reader", "another's");
}

std::vector<std::string> QueryCondition::query_parameters() const {
  const auto held = reader_.lock();
  return text_.parameters;
}

Status QueryCondition::set_query_parameters(std::vector<std::string> parameters) {
  const auto held = reader_.lock();
  FilterText text{text_.expression, std::move(parameters)};
  DDSSEC_ASSIGN_OR_RETURN(auto compiled, reader_.conditions_.compile(text));
  // query_ is changed in place and not replaced, because concurrent reads hold its address.
  text_.parameters = std::move(text.parameters);
  if (!compiled) return {};
  query_->replace(std::move(*compiled));
  reader_.reception_.match(*query_);
  return {};
}

}  // namespace ddssec::rtps
