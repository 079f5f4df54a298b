#include "governance/pattern_set.hpp"

#include <algorithm>

namespace ddssec::governance {
namespace {

// The hash is a polynomial over the octets, modulo 2^64, so that the hash of any part of a name
// follows from the hashes of its prefixes. A collision only costs a match that fails.
constexpr std::uint64_t kBase = 0x9E3779B97F4A7C15u;

std::uint64_t append(std::uint64_t hash, char c) {
  return hash * kBase + static_cast<std::uint8_t>(c) + 1;
}

std::uint64_t hash_of(std::string_view text) {
  std::uint64_t hash = 0;
  for (const char c : text) hash = append(hash, c);
  return hash;
}

// The hashes of all prefixes of a name, and the powers to compute those of parts.
class NameHashes {
 public:
  explicit NameHashes(std::string_view name)
      : beginnings_(name.size() + 1), powers_(name.size() + 1) {
    powers_[0] = 1;
    for (std::size_t i = 0; i < name.size(); ++i) {
      beginnings_[i + 1] = append(beginnings_[i], name[i]);
      powers_[i + 1] = powers_[i] * kBase;
    }
  }
  std::uint64_t part(std::size_t at, std::size_t length) const {
    return beginnings_[at + length] - beginnings_[at] * powers_[length];
  }

 private:
  std::vector<std::uint64_t> beginnings_, powers_;
};

// Inner parts are cut to a power of two. Then only few lengths must be looked up at every position.
constexpr std::size_t kMaxPart = 32;

std::size_t part_length(std::size_t run) {
  std::size_t length = 1;
  while (length * 2 <= std::min(run, kMaxPart)) length *= 2;
  return length;
}

}  // namespace

enum class PartPlace : std::uint8_t { prefix, suffix, part };

// A literal part of an expression by which it can be found.
struct PatternSet::Key {
  PartPlace place;
  std::size_t length;
  std::uint64_t hash;
  // Parts at different places are counted separately.
  std::uint64_t counted_as() const {
    return hash ^ (static_cast<std::uint64_t>(place) * 0xD6E8FEB86659FD93u) ^
           (length * 0xA0761D6478BD642Fu);
  }
};

PatternSet::Id PatternSet::add(std::string_view expression) {
  Pattern pattern(expression);
  auto& ids = pattern.is_literal() ? literals_ : wildcard_ids_;
  const auto [entry, is_new] = ids.try_emplace(pattern.text(), static_cast<Id>(count_));
  if (!is_new) return entry->second;
  if (!pattern.is_literal()) wildcards_.push_back({entry->second, std::move(pattern)});
  ++count_;
  return entry->second;
}

std::vector<PatternSet::Key> PatternSet::keys_of(const Pattern& pattern) {
  std::vector<Key> keys;
  const auto& steps = pattern.steps();
  for (std::size_t at = 0; at < steps.size();) {
    std::string run;
    const std::size_t begin = at;
    for (; at < steps.size() && steps[at].kind == Pattern::Kind::character; ++at) {
      run += static_cast<char>(steps[at].character);
    }
    if (run.empty()) {
      ++at;
    } else if (begin == 0) {
      keys.push_back({PartPlace::prefix, run.size(), hash_of(run)});
    } else if (at == steps.size()) {
      keys.push_back({PartPlace::suffix, run.size(), hash_of(run)});
    } else {
      const std::string_view text = run;
      const auto length = part_length(text.size());
      keys.push_back({PartPlace::part, length, hash_of(text.substr(0, length))});
      keys.push_back({PartPlace::part, length, hash_of(text.substr(text.size() - length))});
    }
  }
  return keys;
}

void PatternSet::place(std::uint32_t wildcard, const Key& key) {
  Index& index = key.place == PartPlace::prefix   ? prefixes_
                 : key.place == PartPlace::suffix ? suffixes_
                                                  : parts_;
  index.by_hash[key.hash].push_back(wildcard);
  if (!std::ranges::count(index.lengths, key.length)) index.lengths.push_back(key.length);
}

void PatternSet::seal() {
  std::unordered_map<std::uint64_t, std::uint32_t> shared;
  std::vector<std::vector<Key>> keys;
  keys.reserve(wildcards_.size());
  for (const auto& wildcard : wildcards_) {
    keys.push_back(keys_of(wildcard.pattern));
    for (const auto& key : keys.back()) ++shared[key.counted_as()];
  }
  for (std::uint32_t i = 0; i < wildcards_.size(); ++i) {
    // Prefers the least shared part, then one at a fixed place (one lookup) over an inner part,
    // then the longest.
    const auto best = std::ranges::min_element(keys[i], {}, [&](const Key& key) {
      return std::tuple(shared[key.counted_as()], key.place == PartPlace::part, ~key.length);
    });
    if (best == keys[i].end()) {
      everywhere_.push_back(i);
    } else {
      place(i, *best);
    }
  }
  wildcard_ids_.clear();
}

// Lists of expressions with a literal part that occurs in a name.
struct PatternSet::Candidates {
  std::vector<const std::vector<std::uint32_t>*> lists;
};

void PatternSet::collect(const Index& index, std::uint64_t hash, Candidates& candidates) {
  const auto entry = index.by_hash.find(hash);
  if (entry != index.by_hash.end()) candidates.lists.push_back(&entry->second);
}

std::size_t PatternSet::lookups_for(std::string_view name) const {
  return prefixes_.lengths.size() + suffixes_.lengths.size() +
         name.size() * (parts_.lengths.size() + 1);
}

void PatternSet::match(std::string_view name, std::vector<Id>& found) const {
  auto unbounded = std::numeric_limits<std::size_t>::max();
  match(name, found, unbounded);
}

bool PatternSet::match(std::string_view name, std::vector<Id>& found, std::size_t& steps) const {
  found.clear();
  constexpr std::size_t kStepsForLookup = 8;
  const auto lookups = lookups_for(name);
  if (steps / kStepsForLookup < lookups) {
    steps = 0;
    return false;
  }
  steps -= lookups * kStepsForLookup;
  if (const auto literal = literals_.find(std::string(name)); literal != literals_.end()) {
    found.push_back(literal->second);
  }
  if (wildcards_.empty()) return true;
  Candidates candidates{.lists = {&everywhere_}};
  const NameHashes hashes(name);
  for (const auto length : prefixes_.lengths) {
    if (length <= name.size()) collect(prefixes_, hashes.part(0, length), candidates);
  }
  for (const auto length : suffixes_.lengths) {
    if (length > name.size()) continue;
    collect(suffixes_, hashes.part(name.size() - length, length), candidates);
  }
  for (const auto length : parts_.lengths) {
    for (std::size_t at = 0; at + length <= name.size(); ++at) {
      collect(parts_, hashes.part(at, length), candidates);
    }
  }
  // An inner part may occur more than once in the name. No expression is in two of the lists.
  auto& lists = candidates.lists;
  std::ranges::sort(lists);
  lists.erase(std::unique(lists.begin(), lists.end()), lists.end());
  for (const auto* list : lists) {
    for (const auto i : *list) {
      const auto matches = wildcards_[i].pattern.matches(name, steps);
      if (!matches) return false;
      if (*matches) found.push_back(wildcards_[i].id);
    }
  }
  std::ranges::sort(found);
  return true;
}

PatternSet::Id PatternSet::first_match(std::string_view name) const {
  std::vector<Id> found;
  match(name, found);
  return found.empty() ? kNone : found.front();
}

}  // namespace ddssec::governance
