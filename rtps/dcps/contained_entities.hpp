// The entities of one kind that an entity contains.
#pragma once

#include <algorithm>

#include "rtps/dcps/entity.hpp"

namespace ddssec::rtps {

/// Makes and deletes none by itself. Those that are left die with it.
template <class Child>
class ContainedEntities {
 public:
  using All = std::vector<std::unique_ptr<Child>>;

  /// `context` outlives it.
  explicit ContainedEntities(ParticipantContext& context) : context_(context) {}

  // Without the participant's lock, with that of callbacks:
  Child* add(std::unique_ptr<Child> child) {
    const std::lock_guard held(context_.mutex());
    children_.push_back(std::move(child));
    return children_.back().get();
  }
  /// Deletes it. Errors: rtps_precondition_not_met (from within a callback, another container's, or
  /// not `unused`).
  Status remove(const Child& child, bool unused) {
    DDSSEC_TRY(check_not_in_callback(context_));
    std::unique_ptr<Child> dying;
    const std::lock_guard held(context_.mutex());
    const auto at = std::ranges::find(children_, &child, &std::unique_ptr<Child>::get);
    if (at == children_.end())
      return precondition_not_met("entity", "one of this participant", "another's");
    if (!unused)
      return precondition_not_met("entity", "one that is empty and unused", "a used one");
    dying = std::move(*at);
    children_.erase(at);
    return {};  // the lock ends before the entity does
  }
  /// All of them leave.
  All release() {
    const std::lock_guard held(context_.mutex());
    return std::exchange(children_, {});
  }

  // With the participant's lock or that of callbacks:
  const All& all() const { return children_; }
  /// Any of that name; nullptr if there is none.
  Child* named(std::string_view name) const requires requires(const Child& child) { child.name(); }
  {
    const auto at = std::ranges::find(
        children_, name, [](const auto& child) -> std::string_view { return child->name(); });
    return at == children_.end() ? nullptr : at->get();
  }

 private:
  ParticipantContext& context_;
  All children_;
};

}  // namespace ddssec::rtps
