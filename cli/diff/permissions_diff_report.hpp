// The result of a comparison of permissions documents.
#pragma once

#include "cli/diff/diff_words.hpp"
#include "cli/diff/permissions_forecast.hpp"
#include "governance/compare/permissions_diff.hpp"

namespace ddssec::cli {

/// The endpoints that a change affects.
template <>
struct FieldsOf<governance::EntityWords> {
  using T = governance::EntityWords;
  static constexpr auto fields() {
    return std::tuple(field<&T::every>(),
                      field<&T::partitions>({.note = "as `tag_set`", .has_same_members = true}),
                      field<&T::example_data_tags>());
  }
};

template <>
struct FieldsOf<governance::PermissionChange> {
  using T = governance::PermissionChange;
  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple(field<&T::subject>()), fields_within(&T::scope),
        std::tuple(
            field<&T::element>(
                {.words = "rule|default|grant|validity|join|subject_name|rewritten"}),
            field("operation", &T::operation, if_any, {.words = "publish|subscribe|relay"}),
            computed<T>("topics", ChangedTopics::of<T>),
            field("partitions", &T::entities, &governance::EntityWords::example_partitions,
                  {"of one endpoint"}),
            computed<T>("endpoints",
                        [](const T& one) {
                          return one.is_about_topics ? std::optional(one.entities) : std::nullopt;
                        },
                        {"null: the change is not about endpoints"}),
            field("old", &T::old_value, if_any), field("new", &T::new_value, if_any),
            field("class", &T::change, {.words = "wider|narrower|mixed|interop|neutral|unknown"}),
            field("hint", &T::hint, if_any)));
  }
};

/// One difference. It points into the comparison.
struct ShownPermissionChange {
  const governance::PermissionChange* by;
  const DiffSides* sides;

  static constexpr auto fields() {
    using T = ShownPermissionChange;
    return std::tuple_cat(fields_within(&T::by),
                          std::tuple(computed<T>("old_at",
                                                 [](const T& one) {
                                                   return place(one.sides->before.path,
                                                                one.by->old_line);
                                                 }),
                                     computed<T>("new_at", [](const T& one) {
                                       return place(one.sides->after.path, one.by->new_line);
                                     })));
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
        computed<T>("verdict", [](const T& one) { return one.diff.verdict; },
                    {.words = "wider|narrower|mixed|neutral|unknown"}),
        computed<T>("breaks_interop", [](const T&) { return false; }, {"never"}),
        field<&T::changes>({.has_own_row = true}),
        field("complete", &T::diff, &governance::PermissionsDiff::is_complete),
        computed<T>("approximate", [](const T& one) { return !one.diff.is_exact; }),
        readings_field<T>(), field("signer", &T::sides, ShownSigners::of),
        field<&T::takes_effect>(
            {"what running participants do: same, live, live when it begins, live if the signer "
             "is believed, restart, refused; in Cyclone DDS also: live, sessions begin again (an "
             "endpoint may lose or gain a right)"}));
  }
  std::string text() const;
};

}  // namespace ddssec::cli
