// Shows the subjects of a comparison, as text and as field lists.
#pragma once

#include <string>

#include "cli/diff/diff_inputs.hpp"
#include "governance/compare/grant_diff.hpp"

namespace ddssec::cli {

/// Returns a text such as "domain 0" or "domains 2-5, every tag but the empty one".
std::string scope_text(const governance::DomainScope& scope);
/// Returns a text such as "topic rt/a" or "topics rt/a*, rt/b* but not rt/bx* (e.g. rt/a)".
std::string topics_text(const governance::TopicSet& topics, const std::string& witness);
/// Returns a text such as "in every partition but the default one (e.g. a)". Empty for the default
/// partition alone.
std::string entities_text(const governance::EntityWords& entities);

template <>
struct FieldsOf<governance::NameSet> {
  using T = governance::NameSet;
  static constexpr std::string_view kDef = "name_set";
  static constexpr auto fields() {
    return std::tuple(
        computed<T>(
            "form",
            [](const T& set) {
              constexpr std::string_view kForms[] = {"every", "every_but", "listed", "some"};
              return kForms[static_cast<std::size_t>(set.form)];
            },
            {.words = "every|every_but|listed|some"}),
        field<&T::expressions>(), field<&T::examples>({.min = 1}));
  }
};

template <>
struct FieldsOf<governance::TopicWords> {
  using T = governance::TopicWords;
  static constexpr auto fields() {
    return std::tuple(field<&T::expression>(),
                      computed<T>("also", [](const T& words) { return if_any(words.also); }),
                      field<&T::except>(), field<&T::more_exceptions>());
  }
};

template <>
struct FieldsOf<governance::DataTag> {
  using T = governance::DataTag;
  static constexpr auto fields() { return std::tuple(field<&T::name>(), field<&T::value>()); }
};

/// The topics that a change affects.
struct ChangedTopics {
  static constexpr std::string_view kDef = "topic_words";
  std::optional<std::string> witness;
  std::vector<governance::TopicWords> sets;
  std::size_t other_sets;
  std::vector<std::string> expressions_old, expressions_new;

  template <class Change>
  static ChangedTopics of(const Change& change) {
    return {change.is_about_topics ? std::optional(change.witness) : std::nullopt,
            change.topics.words, change.topics.others, change.expressions_old,
            change.expressions_new};
  }
  static constexpr auto fields() {
    using T = ChangedTopics;
    return std::tuple(field<&T::witness>({"null: the change is not about topics"}),
                      field<&T::sets>(), field<&T::other_sets>(), field<&T::expressions_old>(),
                      field<&T::expressions_new>());
  }
};

template <>
struct FieldsOf<governance::DomainScope> {
  using T = governance::DomainScope;
  static constexpr auto fields() {
    return std::tuple(field("domains", &T::domains, domains_json, {.def = "domain_ranges"}),
                      computed<T>("tag_set",
                                  [](const T& one) {
                                    return one.has_tags ? std::optional(one.tags) : std::nullopt;
                                  },
                                  {"null: no tags"}));
  }
};

}  // namespace ddssec::cli
