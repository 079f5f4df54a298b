// The result of a comparison of governance documents.
#pragma once

#include "cli/diff/diff_words.hpp"
#include "cli/diff/governance_forecast.hpp"
#include "governance/compare/governance_diff.hpp"

namespace ddssec::cli {

struct ShownProperty {
  std::string_view property;
  std::string witness;

  static constexpr auto fields() {
    using T = ShownProperty;
    return std::tuple(field("property", &T::property), field("witness", &T::witness));
  }
};

/// One difference. What it points to is the comparison's.
struct ShownGovernanceChange {
  using Text = std::optional<std::string>;
  const governance::GovernanceChange* by;
  const DiffSides* sides;

  /// The masks that discovery announces with a document; empty without a rule. The plugin masks
  /// only of a rule.
  Text mask(bool is_new, bool is_plugin_mask) const;
  std::vector<std::string_view> properties(const governance::Properties& properties) const;
  std::vector<ShownProperty> of_some() const;

  static constexpr auto fields() {
    using T = ShownGovernanceChange;
    constexpr Shown kMask{.def = "mask"}, kPluginMask{.def = "mask", .absent = true};
    return std::tuple_cat(
        scope_fields<T>(),
        std::tuple(
            made<T>("topics", [](const T& one) { return ChangedTopics::of(*one.by); }),
            made<T>("element", [](const T& one) { return one.by->element.element; }),
            made<T>("old", [](const T& one) { return one.by->element.old_value; }),
            made<T>("new", [](const T& one) { return one.by->element.new_value; }),
            made<T>("class", [](const T& one) { return one.by->element.change; },
                    {.words = "weaker|stronger|wider|narrower|mixed|neutral"}),
            made<T>("interop", [](const T& one) { return one.by->element.interop; },
                    {.words = "none|endpoint|participant"}),
            made<T>(
                "mask_old", [](const T& one) { return one.mask(false, false); }, kMask),
            made<T>(
                "mask_new", [](const T& one) { return one.mask(true, false); }, kMask),
            made<T>(
                "plugin_mask_old", [](const T& one) { return one.mask(false, true); }, kPluginMask),
            made<T>(
                "plugin_mask_new", [](const T& one) { return one.mask(true, true); }, kPluginMask),
            made<T>("properties_lost", [](const T& one) { return one.properties(one.by->lost); },
                    {.def = "property"}),
            made<T>("properties_gained",
                    [](const T& one) { return one.properties(one.by->gained); },
                    {.def = "property"}),
            made<T>("properties_of_some", [](const T& one) { return one.of_some(); },
                    {"of a whole domain's change, those that only some topics lose or gain"}),
            made<T>("old_at",
                    [](const T& one) { return place(one.sides->before.path, one.by->old_line()); }),
            made<T>("new_at",
                    [](const T& one) { return place(one.sides->after.path, one.by->new_line()); }),
            made<T>("tags",
                    [](const T& one) {
                      const auto& scope = one.by->scope;
                      return scope.has_tags ? std::optional(scope.tags.examples) : std::nullopt;
                    },
                    {.note = "examples of `tag_set`", .absent = true})));
  }
};

/// Rules that are written differently without any effect.
struct ShownRewriting {
  const governance::RewrittenRules* by;

  static constexpr auto fields() {
    using T = ShownRewriting;
    return std::tuple_cat(
        scope_fields<T>(),
        std::tuple(made<T>("only_old", [](const T& one) { return one.by->only_old; }),
                   made<T>("only_new", [](const T& one) { return one.by->only_new; })));
  }
};

/// The result of `governance diff`.
struct GovernanceComparison {
  governance::GovernanceDiff diff;
  DiffSides sides;
  GovernanceForecast live;
  bool only_listed;  ///< the comparison was one of the topics of --topics

  std::vector<ShownGovernanceChange> changes() const;
  std::vector<ShownRewriting> rewritten() const;

  static constexpr auto fields() {
    using T = GovernanceComparison;
    constexpr Shown kRanges{.def = "domain_ranges"};
    return std::tuple(
        made<T>("verdict", [](const T& one) { return one.diff.verdict; },
                {.words = "weaker|stronger|mixed|neutral|unknown"}),
        made<T>("breaks_interop", [](const T& one) { return !one.diff.flag_day_domains.empty(); }),
        made<T>(
            "flag_day_domains",
            [](const T& one) { return domains_json(one.diff.flag_day_domains); }, kRanges),
        made<T>("changes", [](const T& one) { return one.changes(); }, {.apart = true}),
        made<T>("rewritten", [](const T& one) { return one.rewritten(); }),
        made<T>(
            "unknown_domains", [](const T& one) { return domains_json(one.diff.unknown_domains); },
            kRanges),
        made<T>("complete", [](const T& one) { return one.diff.complete; }),
        made<T>("readings",
                [](const T& one) { return ShownReadings::of(one.diff.readings, one.sides); },
                {"what other products may read differently, and only one document has"}),
        made<T>("signer", [](const T& one) { return ShownSigners::of(one.sides); }),
        field("live", &T::live,
              {"what running participants do: same, live, two phases, live unless in use, live if "
               "the signer is believed, refused as a roll-back, refused without a revision, "
               "restart"}));
  }
  std::string text() const;
};

}  // namespace ddssec::cli
