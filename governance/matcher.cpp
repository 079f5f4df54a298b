#include "governance/matcher.hpp"

#include <algorithm>

namespace ddssec::governance {
namespace {

// A polynomial over the octets, modulo 2^64, so that the hash of any part of a name follows from
// the hashes of its beginnings. Collisions only cost a match that fails.
constexpr std::uint64_t kBase = 0x9E3779B97F4A7C15u;

std::uint64_t append(std::uint64_t hash, char c) {
  return hash * kBase + static_cast<std::uint8_t>(c) + 1;
}

std::uint64_t hash_of(std::string_view text) {
  std::uint64_t hash = 0;
  for (const char c : text) hash = append(hash, c);
  return hash;
}

/// The hashes of all beginnings of a name, and the powers to take parts out of them.
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

/// Inner parts are cut to a power of two, so that few lengths have to be looked up everywhere.
constexpr std::size_t kLongestPart = 32;

std::size_t part_length(std::size_t run) {
  std::size_t length = 1;
  while (length * 2 <= std::min(run, kLongestPart)) length *= 2;
  return length;
}

}  // namespace

enum class PartPlace : std::uint8_t { prefix, suffix, part };

/// A literal part of an expression by which it can be found.
struct PatternSet::Key {
  PartPlace place;
  std::size_t length;
  std::uint64_t hash;
  /// Different places never share a count.
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
    // The least shared, then a fixed place (one look-up) before an inner part, then the longest.
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

void PatternSet::try_index(const Index& index, std::uint64_t hash, std::string_view name,
                           std::vector<Id>& found) const {
  const auto entry = index.by_hash.find(hash);
  if (entry == index.by_hash.end()) return;
  for (const auto i : entry->second) {
    if (wildcards_[i].pattern.matches(name)) found.push_back(wildcards_[i].id);
  }
}

void PatternSet::match(std::string_view name, std::vector<Id>& found) const {
  found.clear();
  if (const auto literal = literals_.find(std::string(name)); literal != literals_.end()) {
    found.push_back(literal->second);
  }
  if (wildcards_.empty()) return;
  const NameHashes hashes(name);
  for (const auto length : prefixes_.lengths) {
    if (length <= name.size()) try_index(prefixes_, hashes.part(0, length), name, found);
  }
  for (const auto length : suffixes_.lengths) {
    if (length > name.size()) continue;
    try_index(suffixes_, hashes.part(name.size() - length, length), name, found);
  }
  for (const auto length : parts_.lengths) {
    for (std::size_t at = 0; at + length <= name.size(); ++at) {
      try_index(parts_, hashes.part(at, length), name, found);
    }
  }
  for (const auto i : everywhere_) {
    if (wildcards_[i].pattern.matches(name)) found.push_back(wildcards_[i].id);
  }
  // An inner part may occur more than once in the name.
  std::ranges::sort(found);
  found.erase(std::unique(found.begin(), found.end()), found.end());
}

PatternSet::Id PatternSet::first_match(std::string_view name) const {
  std::vector<Id> found;
  match(name, found);
  return found.empty() ? kNone : found.front();
}

}  // namespace ddssec::governance
