#include "governance/decision.hpp"

#include <algorithm>
#include <optional>
#include <queue>

#include <fmt/format.h>

namespace ddssec::governance {

// A requested partition. It is compiled at most once, however many expressions are listed.
class RequestedPartition {
 public:
  explicit RequestedPartition(std::string_view text) : text_(text) {}
  std::string_view text() const { return text_; }
  const Pattern& pattern() {
    if (!pattern_) pattern_.emplace(text_);
    return *pattern_;
  }

 private:
  std::string_view text_;
  std::optional<Pattern> pattern_;
};

namespace {

// Characters with which a requested partition may stand for more than its own text. Hosts differ in
// whether a backslash escapes there, so it is included: an allow rule must be right either way.
constexpr std::string_view kSpecial = "*?[\\";

std::string_view longest_literal_beginning(std::string_view requested) {
  return requested.substr(0, requested.find_first_of(kSpecial));
}

bool may_stand_for_many(std::string_view requested) {
  return requested.find_first_of(kSpecial) != requested.npos;
}

bool has_backslash(std::string_view requested) { return requested.find('\\') != requested.npos; }

// True if `listed` matches every name that `requested` stands for, as far as a simple check can
// tell.
bool covers(const Pattern& listed, std::string_view requested) {
  if (!may_stand_for_many(requested)) return listed.matches(requested);
  const auto& steps = listed.steps();
  if (steps.empty()) return false;
  if (listed.text() == requested && !has_backslash(requested)) return true;
  if (steps.back().kind != Pattern::Kind::star) return false;
  const auto beginning = longest_literal_beginning(requested);
  const std::size_t prefix = steps.size() - 1;
  const bool plain = std::all_of(steps.begin(), steps.end() - 1, [](const Pattern::Step& step) {
    return step.kind == Pattern::Kind::character;
  });
  return plain && prefix <= beginning.size() &&
         listed.matches(beginning);  // the prefix is literal and any text may follow
}

// False only if a simple check shows that no name is both listed and requested.
bool may_overlap(const Pattern& listed, RequestedPartition& requested) {
  const auto text = requested.text();
  if (!may_stand_for_many(text)) return listed.matches(text);
  return !listed.is_literal() || has_backslash(text) || listed.text() == text ||
         requested.pattern().matches(listed.text());
}

bool lists(const std::vector<DataTag>& listed, const DataTag& tag) {
  return std::ranges::find(listed, tag) != listed.end();
}

bool data_tags_fit(const GrantRule& rule, const Criteria& criteria, std::span<const DataTag> tags) {
  if (!criteria.data_tags) return !rule.allow || tags.empty();
  const auto listed = [&](const DataTag& tag) { return lists(*criteria.data_tags, tag); };
  return rule.allow ? std::ranges::all_of(tags, listed) : std::ranges::any_of(tags, listed);
}

// True if the element matches whatever partitions and data tags an entity has.
bool is_unconditional(const Criteria& criteria) {
  return !criteria.partitions && !criteria.data_tags;
}

void append_part(std::string& key, std::string_view part) {
  const auto size = static_cast<std::uint32_t>(part.size());
  for (unsigned shift = 0; shift < 32; shift += 8) key += static_cast<char>(size >> shift & 0xFF);
  key += part;
}

std::string cache_key(Action action, const Request& request) {
  std::string key(1, static_cast<char>('0' + static_cast<int>(action)));
  append_part(key, request.topic);
  for (const auto partition : request.partitions) append_part(key, partition);
  if (!request.data_tags.empty()) key += "tags";
  for (const auto& tag : request.data_tags) {
    append_part(key, tag.name);
    append_part(key, tag.value);
  }
  return key;
}

}  // namespace

std::string describe_domain(DomainId domain, std::string_view tag) {
  auto text = "domain " + std::to_string(domain);
  if (!tag.empty()) text += " with the tag \"" + std::string(tag.substr(0, 256)) + '"';
  return text;
}

namespace {

// "0, 5 to 7": the domains of the document, for an error message.
std::string describe_domains(const Governance& governance) {
  constexpr std::size_t kMax = 128;
  std::string out;
  for (const auto& rule : governance.domain_rules)
    for (const auto& range : rule.domains.ranges) {
      if (out.size() > kMax) return out + ", ...";
      out += (out.empty() ? "" : ", ") + std::to_string(range.first);
      if (range.first != range.last) out += " to " + std::to_string(range.last);
    }
  return out.empty() ? "none" : out;
}

}  // namespace

std::string_view to_string(Action action) {
  constexpr std::array<std::string_view, 3> kNames = {"publish", "subscribe", "relay"};
  return kNames.at(static_cast<std::size_t>(action));
}

bool decides_joining(const GrantRule& rule) {
  return rule.allow || (rule.publish.empty() && rule.subscribe.empty());
}

CompiledGrant::CompiledGrant(std::shared_ptr<const Permissions> permissions, const Grant& grant,
                             DomainId domain, PartitionMatch partition_match, std::string_view tag)
    : permissions_(std::move(permissions)), grant_(grant), partition_match_(partition_match) {
  for (const auto& rule : grant_.rules) {
    if (rule.domains.contains(domain, tag)) add_rule(rule);
  }
  for (auto& index : actions_) index.topics.seal();
  partition_numbers_.clear();
  participant_ = participant_decision(domain, tag);
}

void CompiledGrant::add_rule(const GrantRule& rule) {
  add_entries(Action::publish, rule, rule.publish);
  add_entries(Action::subscribe, rule, rule.subscribe);
  add_entries(Action::relay, rule, rule.relay);
}

void CompiledGrant::add_entries(Action action, const GrantRule& rule,
                                const std::vector<Criteria>& list) {
  auto& index = actions_.at(static_cast<std::size_t>(action));
  for (const auto& criteria : list) {
    const auto number = static_cast<std::uint32_t>(index.entries.size());
    auto& entry = index.entries.emplace_back(Entry{&rule, &criteria, {}});
    if (criteria.partitions) {
      for (const auto& text : *criteria.partitions) {
        entry.partitions.push_back(partition_pattern(text.text));
      }
    }
    for (const auto& topic : criteria.topics) {
      const auto id = index.topics.add(topic.text);
      if (id >= index.entries_of_topic.size()) index.entries_of_topic.resize(id + 1);
      auto& entries = index.entries_of_topic[id];
      if (entries.empty() || entries.back() != number) entries.push_back(number);
    }
  }
}

std::vector<const Criteria*> CompiledGrant::allowed(Action action) const {
  std::vector<const Criteria*> out;
  for (const auto& entry : actions_.at(static_cast<std::size_t>(action)).entries)
    if (entry.rule->allow) out.push_back(entry.criteria);
  return out;
}

std::uint32_t CompiledGrant::partition_pattern(const std::string& text) {
  const auto next = static_cast<std::uint32_t>(partition_patterns_.size());
  const auto [entry, is_new] = partition_numbers_.try_emplace(text, next);
  if (is_new) partition_patterns_.emplace_back(text);
  return entry->second;
}

Decision CompiledGrant::participant_decision(DomainId domain, std::string_view tag) const {
  const auto first = std::ranges::find_if(grant_.rules, [&](const GrantRule& rule) {
    return decides_joining(rule) && rule.domains.contains(domain, tag);
  });
  if (first != grant_.rules.end()) return {first->allow, &*first, nullptr};
  return {grant_.default_allow, nullptr, nullptr};
}

template <class Fits>
Decision CompiledGrant::first_fitting(const ActionIndex& index, std::string_view topic,
                                      Fits&& fits) const {
  std::vector<PatternSet::Id> matching;
  index.topics.match(topic, matching);
  // Visits all entries of all matching expressions in document order. Entries that are never
  // reached are not sorted.
  using Cursor = std::pair<std::uint32_t, std::pair<PatternSet::Id, std::size_t>>;
  std::vector<Cursor> first;
  for (const auto id : matching) first.push_back({index.entries_of_topic[id].front(), {id, 0}});
  std::priority_queue<Cursor, std::vector<Cursor>, std::greater<>> next({}, std::move(first));
  while (!next.empty()) {
    auto [number, place] = next.top();
    next.pop();
    const Entry& entry = index.entries[number];
    if (fits(entry)) return {entry.rule->allow, entry.rule, entry.criteria};
    const auto& entries = index.entries_of_topic[place.first];
    if (++place.second < entries.size()) next.push({entries[place.second], place});
  }
  return {grant_.default_allow, nullptr, nullptr};
}

bool CompiledGrant::partitions_fit(const Entry& entry,
                                   std::span<RequestedPartition> partitions) const {
  const bool allow = entry.rule->allow;
  if (!entry.criteria->partitions && !allow) return true;
  const auto listed = [&](RequestedPartition& requested) {
    if (!entry.criteria->partitions) return requested.text().empty();
    return std::ranges::any_of(entry.partitions, [&](std::uint32_t i) {
      const Pattern& pattern = partition_patterns_[i];
      return allow ? covers(pattern, requested.text()) : may_overlap(pattern, requested);
    });
  };
  const bool all = allow && partition_match_ == PartitionMatch::all;
  return all ? std::ranges::all_of(partitions, listed) : std::ranges::any_of(partitions, listed);
}

Decision CompiledGrant::judge(Action action, const Request& request) const {
  const std::string key = cache_key(action, request);
  if (const auto decision = seen_.find(key)) return *decision;
  std::vector<RequestedPartition> partitions(request.partitions.begin(), request.partitions.end());
  if (partitions.empty()) partitions.emplace_back("");
  const auto& index = actions_.at(static_cast<std::size_t>(action));
  const Decision decision = first_fitting(index, request.topic, [&](const Entry& entry) {
    return partitions_fit(entry, partitions) &&
           data_tags_fit(*entry.rule, *entry.criteria, request.data_tags);
  });
  seen_.remember(key, decision);
  return decision;
}

Decision CompiledGrant::judge_topic(Action action, std::string_view topic) const {
  // The key of an entity never begins with 't'.
  std::string key(1, 't');
  key += cache_key(action, {.topic = topic});
  if (const auto decision = seen_.find(key)) return *decision;
  const auto& index = actions_.at(static_cast<std::size_t>(action));
  const Decision decision = first_fitting(index, topic, [](const Entry& entry) {
    return entry.rule->allow || is_unconditional(*entry.criteria);
  });
  seen_.remember(key, decision);
  return decision;
}

CompiledGovernance::CompiledGovernance(std::shared_ptr<const Governance> governance,
                                       const DomainRule& rule)
    : governance_(std::move(governance)), rule_(rule) {
  for (const auto& topic_rule : rule_.topic_rules) {
    const auto id = topics_.add(topic_rule.topic_expression);
    if (id == rule_of_topic_.size()) rule_of_topic_.push_back(&topic_rule);
  }
  topics_.seal();
}

Result<std::shared_ptr<const CompiledGovernance>> CompiledGovernance::make(
    std::shared_ptr<const Governance> governance, DomainId domain, std::string_view tag) {
  const DomainRule* rule = governance->find(domain, tag);
  if (!rule) {
    return fail(Code::domain_not_covered,
                {.line = governance->domain_rules.empty() ? 0 : governance->domain_rules[0].line,
                 .field = "<domains>",
                 .note = fmt::format("the participant is in {}, the document covers {}",
                                     describe_domain(domain, tag), describe_domains(*governance))});
  }
  return std::make_shared<const CompiledGovernance>(std::move(governance), *rule);
}

const TopicRule* CompiledGovernance::topic_rule(std::string_view topic) const {
  const std::string key(topic);
  if (const auto rule = seen_.find(key)) return *rule;
  const auto id = topics_.first_match(topic);
  const TopicRule* rule = id == PatternSet::kNone ? nullptr : rule_of_topic_[id];
  seen_.remember(key, rule);
  return rule;
}

}  // namespace ddssec::governance
