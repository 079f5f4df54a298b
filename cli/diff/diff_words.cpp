#include "cli/diff/diff_words.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "governance/pattern.hpp"

namespace ddssec::cli {
namespace {

using governance::NameSet;

constexpr std::size_t kMaxWordsShown = 3;

// For example "a, b* and 2 more". The empty name has a word of its own.
std::string listed(const std::vector<std::string>& names, std::string_view empty_name) {
  std::vector<std::string> words;
  for (const auto& name : names)
    words.push_back(name.empty() ? std::string(empty_name) : name_text(name));
  const auto count = std::min(kMaxWordsShown, words.size());
  auto text =
      fmt::format("{}", fmt::join(words.begin(), words.begin() + static_cast<long>(count), ", "));
  if (words.size() > count) text += fmt::format(" and {} more", words.size() - count);
  return text;
}

// For example "(e.g. a)". Empty if there is no example with a name.
std::string example(const NameSet& set) {
  const auto found =
      std::ranges::find_if(set.examples, [](const std::string& name) { return !name.empty(); });
  if (found == set.examples.end()) return {};
  return fmt::format(" (e.g. {})", name_text(*found));
}

bool all_literal(const NameSet& set) {
  return std::ranges::all_of(set.expressions, [](const std::string& expression) {
    return governance::Pattern(expression).is_literal();
  });
}

// For example "tag", "tags" and "the empty one".
struct Nouns {
  std::string_view one, many, empty_name;
};

std::string outcome_text(const NameSet& set, const Nouns& nouns) {
  switch (set.form) {
    case NameSet::Form::every:
      return fmt::format("every {}", nouns.one);
    case NameSet::Form::every_but:
      return fmt::format("every {} but {}{}", nouns.one, listed(set.expressions, nouns.empty_name),
                         example(set));
    case NameSet::Form::listed: {
      const bool one = set.expressions.size() == 1 && all_literal(set);
      if (one && set.is_only_empty_name()) return std::string(nouns.empty_name);
      return fmt::format("{} {}{}", one ? nouns.one : nouns.many,
                         listed(set.expressions, nouns.empty_name),
                         all_literal(set) ? std::string() : example(set));
    }
    case NameSet::Form::some:
      break;
  }
  return fmt::format("some {}, such as {}", nouns.many, listed(set.examples, nouns.empty_name));
}

std::string outcome_text(const governance::TopicWords& words) {
  auto text = name_text(words.expression);
  if (!words.also.empty()) text += fmt::format(" that match {} too", name_text(words.also));
  if (words.except.empty()) return text;
  text += fmt::format(" but not {}", listed(words.except, "(empty name)"));
  return words.more_exceptions ? text + " and others" : text;
}

}  // namespace

std::string scope_text(const governance::DomainScope& scope) {
  auto text = domains_text(scope.domains);
  if (!scope.has_tags) return text;
  if (scope.tags.is_only_empty_name()) return text + " without a tag";
  return text + ", " + outcome_text(scope.tags, {"tag", "tags", "the empty one"});
}

std::string topics_text(const governance::TopicSet& topics, const std::string& witness) {
  if (topics.words.empty()) return "topics such as " + name_text(witness);
  const auto& first = topics.words.front();
  const bool one = topics.words.size() == 1 && topics.others == 0 &&
                   governance::Pattern(first.expression).is_literal();
  std::vector<std::string> words;
  for (const auto& each : topics.words) words.push_back(outcome_text(each));
  auto text = fmt::format("{}", fmt::join(words, "; "));
  if (one) return "topic " + text;
  if (topics.others > 0) text += fmt::format(" and {} more", topics.others);
  return fmt::format("topics {} (e.g. {})", text, name_text(witness));
}

std::string entities_text(const governance::EntityWords& entities) {
  std::string text;
  if (entities.every) return "in every partition";
  if (entities.partitions) {
    if (entities.partitions->is_only_empty_name()) return {};
    text =
        "in " + outcome_text(*entities.partitions, {"partition", "partitions", "the default one"});
  } else {
    text = "in partitions " + listed(entities.example_partitions, "the default one") +
           (entities.example_partitions.size() > 1 ? " together" : "");
    if (entities.example_partitions == std::vector<std::string>{""}) text.clear();
  }
  if (entities.partitions || entities.example_data_tags.empty()) return text;
  std::vector<std::string> tags;
  for (const auto& tag : entities.example_data_tags)
    tags.push_back(name_text(tag.name + "=" + tag.value));
  return text + (text.empty() ? "" : ", ") +
         fmt::format("of endpoints with data tags such as {}", fmt::join(tags, ", "));
}

}  // namespace ddssec::cli
