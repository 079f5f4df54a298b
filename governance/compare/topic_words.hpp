// Describes in words which topics a change affects.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "governance/compare/topic_pairs.hpp"

namespace ddssec::governance {

/// The names that both `expression` and `also` match, and none of `except`.
struct TopicWords {
  std::string expression = "*";
  std::string also = {};
  std::vector<std::string> except = {};
  /// True if there may be more exceptions.
  bool more_exceptions = false;
  bool operator==(const TopicWords&) const = default;
};

/// Sets of names that together describe the affected topics.
struct TopicSet {
  std::vector<TopicWords> words = {};
  /// The number of further sets.
  std::size_t others = 0;
};

/// Describes the names for which these pairs of rules decide, each once. At most `max_pairs` sets
/// are put into words.
TopicSet topics_in_words(const RuleList& old_list, const RuleList& new_list,
                         std::span<const TopicPair> pairs, SetEffort* effort = nullptr,
                         std::size_t max_pairs = 3);

}  // namespace ddssec::governance
