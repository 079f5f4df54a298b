// The entities of one kind that an entity contains.
#pragma once

#include <algorithm>

#include "rtps/dcps/entity.hpp"

namespace ddssec::rtps {

/// Owns the contained entities; those that remain are deleted with it. It creates none itself.
template <class Child>
class ContainedEntities {
 public:
  using All = std::vector<std::unique_ptr<Child>>;

  /// `context` must outlive this object.
  explicit ContainedEntities(ParticipantContext& context) : context_(context) {}

  // The caller holds the lock of members, but not the participant's lock:
  Child* add(std::unique_ptr<Child> child) {
    const std::lock_guard held(context_.mutex());
    children_.push_back(std::move(child));
    return children_.back().get();
  }
  /// Deletes the entity. No listener may be called meanwhile (NoCallbacks). Errors:
  /// rtps_precondition_not_met (the entity is in another container, or `unused` is false).
  Status remove(const Child& child, bool unused) {
    std::unique_ptr<Child> dying;
    const std::lock_guard held(context_.mutex());
    const auto at = std::ranges::find(children_, &child, &std::unique_ptr<Child>::get);
    if (at == children_.end())
      return precondition_not_met_error("entity", "one of this participant", "another's");
    if (!unused)
      return precondition_not_met_error("entity", "one that is empty and unused", "a used one");
    dying = std::move(*at);
    children_.erase(at);
    return {};  // the lock is released before the entity is destroyed
  }
  /// Removes all entities and returns them.
  All release() {
    const std::lock_guard held(context_.mutex());
    return std::exchange(children_, {});
  }

  // The caller holds the participant's lock or the lock of members:
  const All& all() const { return children_; }
  /// Returns any entity with that name, or nullptr if there is none.
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
