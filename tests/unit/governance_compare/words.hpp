// All short names over a small alphabet, and a pool of expressions with the names that each of them
// matches.
#pragma once

#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "governance/pattern.hpp"

namespace ddssec::governance::words {

/// Returns every word over the alphabet with at most so many letters, shortest first.
inline std::vector<std::string> all_words(std::string_view alphabet, std::size_t longest) {
  std::vector<std::string> words = {""};
  for (std::size_t from = 0, length = 0; length < longest; ++length) {
    const std::size_t to = words.size();
    for (; from < to; ++from) {
      for (const char c : alphabet) words.push_back(words[from] + c);
    }
  }
  return words;
}

/// An expression and, for each word, whether the expression matches it according to Pattern.
struct KnownExpression {
  std::string text;
  std::vector<bool> matches;
};

/// Returns every expression of at most so many parts.
inline std::vector<KnownExpression> all_expressions(const std::vector<std::string>& words,
                                                    std::size_t max_parts) {
  static constexpr std::string_view kParts[] = {"a", "b", "*", "?", "[ab]", "[!a]"};
  std::vector<std::string> texts = {""};
  for (std::size_t from = 0, parts = 0; parts < max_parts; ++parts) {
    const std::size_t to = texts.size();
    for (; from < to; ++from) {
      for (const auto part : kParts) texts.push_back(texts[from] + std::string(part));
    }
  }
  std::vector<KnownExpression> pool;
  for (const auto& text : texts) {
    const Pattern pattern(text);
    KnownExpression known{text, {}};
    for (const auto& word : words) known.matches.push_back(pattern.matches(word));
    pool.push_back(std::move(known));
  }
  return pool;
}

/// Random numbers from a seed, which are the same on every machine.
class Dice {
 public:
  explicit Dice(std::uint32_t seed) : generator_(seed) {}
  std::uint32_t below(std::size_t n) { return static_cast<std::uint32_t>(generator_() % n); }
  bool once_in(std::size_t n) { return below(n) == 0; }

 private:
  std::mt19937 generator_;
};

/// Expressions by their text, with the words that they match.
class Pool {
 public:
  Pool(std::size_t longest, std::size_t max_parts)
      : words_(all_words("abc", longest)), all_(all_expressions(words_, max_parts)) {
    for (std::size_t i = 0; i < all_.size(); ++i) by_text_[all_[i].text] = i;
  }
  const std::vector<std::string>& words() const { return words_; }
  const std::string& random(Dice& dice) const { return all_[dice.below(all_.size())].text; }
  const std::vector<bool>& matches(const std::string& text) const {
    return all_[by_text_.at(text)].matches;
  }

 private:
  std::vector<std::string> words_;
  std::vector<KnownExpression> all_;
  std::map<std::string, std::size_t> by_text_;
};

}  // namespace ddssec::governance::words
