// The result of a comparison of permissions documents.
#pragma once

#include "cli/diff/diff_words.hpp"
#include "cli/diff/permissions_forecast.hpp"
#include "governance/compare/permissions_diff.hpp"

namespace ddssec::cli {

/// The endpoints that a change concerns.
template <>
struct Listed<governance::EntityWords> {
  using T = governance::EntityWords;
  static constexpr auto fields() {
    return std::tuple(field("every", &T::every),
                      field("partitions", &T::partitions, {.note = "as `tag_set`", .same = true}),
                      field("example_data_tags", &T::example_data_tags));
  }
};

/// One difference. What it points to is the comparison's.
struct ShownPermissionChange {
  const governance::PermissionChange* by;
  const DiffSides* sides;

  static constexpr auto fields() {
    using T = ShownPermissionChange;
    return std::tuple_cat(
        std::tuple(made<T>("subject", [](const T& one) { return one.by->subject; })),
        scope_fields<T>(),
        std::tuple(
            made<T>("element", [](const T& one) { return one.by->element; },
                    {.words = "rule|default|grant|validity|join|subject_name|rewritten"}),
            made<T>("operation", [](const T& one) { return if_any(one.by->operation); },
                    {.words = "publish|subscribe|relay"}),
            made<T>("topics", [](const T& one) { return ChangedTopics::of(*one.by); }),
            made<T>("partitions", [](const T& one) { return one.by->entities.example_partitions; },
                    {"of one endpoint"}),
            made<T>("endpoints",
                    [](const T& one) {
                      return one.by->is_about_topics ? std::optional(one.by->entities)
                                                     : std::nullopt;
                    },
                    {"null: the change is not about endpoints"}),
            made<T>("old", [](const T& one) { return if_any(one.by->old_value); }),
            made<T>("new", [](const T& one) { return if_any(one.by->new_value); }),
            made<T>("class", [](const T& one) { return one.by->change; },
                    {.words = "wider|narrower|mixed|interop|neutral|unknown"}),
            made<T>("hint", [](const T& one) { return if_any(one.by->hint); }),
            made<T>("old_at",
                    [](const T& one) { return place(one.sides->before.path, one.by->old_line); }),
            made<T>("new_at",
                    [](const T& one) { return place(one.sides->after.path, one.by->new_line); })));
  }
};

/// The result of `permissions diff`.
struct PermissionsComparison {
  governance::PermissionsDiff diff;
  DiffSides sides;
  PermissionsForecast takes_effect;

  std::vector<ShownPermissionChange> changes() const;

  static constexpr auto fields() {
    using T = PermissionsComparison;
    return std::tuple(
        made<T>("verdict", [](const T& one) { return one.diff.verdict; },
                {.words = "wider|narrower|mixed|neutral|unknown"}),
        made<T>("breaks_interop", [](const T&) { return false; }, {"never"}),
        made<T>("changes", [](const T& one) { return one.changes(); }, {.apart = true}),
        made<T>("complete", [](const T& one) { return one.diff.is_complete; }),
        made<T>("approximate", [](const T& one) { return !one.diff.is_exact; }),
        made<T>("readings",
                [](const T& one) { return ShownReadings::of(one.diff.readings, one.sides); },
                {"what other products may read differently, and only one document has"}),
        made<T>("signer", [](const T& one) { return ShownSigners::of(one.sides); }),
        field("takes_effect", &T::takes_effect,
              {"what running participants do: same, live, live when it begins, live if the signer "
               "is believed, restart, refused"}));
  }
  std::string text() const;
};

}  // namespace ddssec::cli
