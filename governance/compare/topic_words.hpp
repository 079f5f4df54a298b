// Which topics a change is about, in words.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "governance/compare/topic_pairs.hpp"

namespace ddssec::governance {

/// The names that `expression` matches and `also` too, and none of `except`.
struct TopicWords {
  std::string expression = "*";
  std::string also = {};
  std::vector<std::string> except = {};
  /// There may be more exceptions.
  bool more_exceptions = false;
  bool operator==(const TopicWords&) const = default;
};

/// Some sets of names, together what a change is about.
struct TopicSet {
  std::vector<TopicWords> words = {};
  /// How many more sets there are.
  std::size_t others = 0;
};

/// The names that are left to these pairs of rules, each once. At most `most` are put into words.
TopicSet topics_in_words(const RuleList& old_list, const RuleList& new_list,
                         std::span<const TopicPair> pairs, SetEffort* effort = nullptr,
                         std::size_t most = 3);

}  // namespace ddssec::governance
