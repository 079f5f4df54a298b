// The result of a comparison of governance documents.
#pragma once

#include "cli/diff/diff_words.hpp"
#include "cli/diff/governance_forecast.hpp"
#include "governance/compare/governance_diff.hpp"

namespace ddssec::cli {

/// Returns a mask that discovery announces with a document. Empty if there is no rule.
std::optional<std::string> announced_mask(const governance::GovernanceChange& change, bool is_new,
                                          bool is_plugin_mask);
std::vector<std::string_view> words_of(const governance::Properties& properties);

template <>
struct FieldsOf<governance::ElementChange> {
  using T = governance::ElementChange;
  static constexpr auto fields() {
    return std::tuple(
        field<&T::element>(), field("old", &T::old_value), field("new", &T::new_value),
        field("class", &T::change, {.words = "weaker|stronger|wider|narrower|mixed|neutral"}),
        field<&T::interop>({.words = "none|endpoint|participant"}));
  }
};

template <>
struct FieldsOf<governance::PropertyOfSome> {
  using T = governance::PropertyOfSome;
  static constexpr auto fields() {
    return std::tuple(
        computed<T>("property", [](const T& one) { return governance::to_string(one.property); }),
        field<&T::witness>());
  }
};

template <>
struct FieldsOf<governance::GovernanceChange> {
  using T = governance::GovernanceChange;
  static constexpr auto fields() {
    constexpr FieldOptions kMask{.def = "mask"}, kPluginMask{.def = "mask", .omits_empty = true};
    constexpr FieldOptions kProperties{.def = "property"};
    return std::tuple_cat(
        fields_within(&T::scope), std::tuple(computed<T>("topics", ChangedTopics::of<T>)),
        fields_within(&T::element),
        std::tuple(
            computed<T>(
                "mask_old", [](const T& one) { return announced_mask(one, false, false); }, kMask),
            computed<T>(
                "mask_new", [](const T& one) { return announced_mask(one, true, false); }, kMask),
            computed<T>(
                "plugin_mask_old", [](const T& one) { return announced_mask(one, false, true); },
                kPluginMask),
            computed<T>(
                "plugin_mask_new", [](const T& one) { return announced_mask(one, true, true); },
                kPluginMask),
            field("properties_lost", &T::lost, words_of, kProperties),
            field("properties_gained", &T::gained, words_of, kProperties),
            field("properties_of_some", &T::of_some,
                  {"of a whole domain's change, those that only some topics lose or gain"})));
  }
};

/// Rules that are written differently without any effect.
template <>
struct FieldsOf<governance::RewrittenRules> {
  using T = governance::RewrittenRules;
  static constexpr auto fields() {
    return std::tuple_cat(fields_within(&T::scope),
                          std::tuple(field<&T::only_old>(), field<&T::only_new>()));
  }
};

/// One difference. It points into the comparison.
struct ShownGovernanceChange {
  const governance::GovernanceChange* by;
  const DiffSides* sides;

  static constexpr auto fields() {
    using T = ShownGovernanceChange;
    return std::tuple_cat(
        fields_within(&T::by),
        std::tuple(
            computed<T>(
                "old_at",
                [](const T& one) { return place(one.sides->before.path, one.by->old_line()); }),
            computed<T>(
                "new_at",
                [](const T& one) { return place(one.sides->after.path, one.by->new_line()); }),
            computed<T>("tags",
                        [](const T& one) {
                          const auto& scope = one.by->scope;
                          return scope.has_tags ? std::optional(scope.tags.examples) : std::nullopt;
                        },
                        {.note = "examples of `tag_set`", .omits_empty = true})));
  }
};

/// The result of `governance diff`.
struct GovernanceComparison {
  governance::GovernanceDiff diff;
  DiffSides sides;
  GovernanceForecast live;
  bool only_listed;  ///< only the topics of --topics were compared

  std::vector<ShownGovernanceChange> changes() const;

  static constexpr auto fields() {
    using T = GovernanceComparison;
    using Diff = governance::GovernanceDiff;
    constexpr FieldOptions kRanges{.def = "domain_ranges"};
    return std::tuple(
        field("verdict", &T::diff, &Diff::verdict,
              {.words = "weaker|stronger|mixed|neutral|unknown"}),
        computed<T>("breaks_interop",
                    [](const T& one) { return !one.diff.flag_day_domains.empty(); }),
        computed<T>(
            "flag_day_domains",
            [](const T& one) { return domains_json(one.diff.flag_day_domains); }, kRanges),
        field<&T::changes>({.has_own_row = true}), field("rewritten", &T::diff, &Diff::rewritten),
        computed<T>(
            "unknown_domains", [](const T& one) { return domains_json(one.diff.unknown_domains); },
            kRanges),
        field("complete", &T::diff, &Diff::complete), readings_field<T>(),
        field("signer", &T::sides, ShownSigners::of),
        field<&T::live>(
            {"what running participants do: same, live, two phases, live unless in use, live if "
             "the signer is believed, refused as a roll-back, refused without a revision, "
             "restart"}));
  }
  std::string text() const;
};

}  // namespace ddssec::cli
