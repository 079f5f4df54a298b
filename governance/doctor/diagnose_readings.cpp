// Finds topics that are protected or refused only by ddssec's reading of the expressions.
#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "governance/compare/governance_elements.hpp"
#include "governance/decision.hpp"
#include "governance/dialect.hpp"
#include "governance/doctor/checks.hpp"
#include "governance/doctor/product_decision.hpp"
#include "governance/product_reading.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance::doctor {
namespace {

constexpr std::pair<Product, StockProduct> kStockProductPairs[] = {
    {Product::cyclonedds, StockProduct::cyclonedds}, {Product::fastdds, StockProduct::fastdds}};

// A topic for which the product does less than ddssec.
struct Loss {
  Text expression;      // an expression that the product reads in its own way
  std::string because;  // a clause about what the product does
};

enum List : std::uint8_t { kOurs, kTheirs, kWithBracket };

// Cyclone DDS's brackets match "]", but no topic name contains it.
constexpr RankedExpression kBracket{"*]*", kWithBracket, 0};

bool is_name(const NameAtom& atom) { return !atom.witness.empty() && !atom.rank_in(kWithBracket); }

bool is_less(const ElementChange& change) {
  using enum ChangeClass;
  return change.change == weaker || change.change == wider || change.change == mixed;
}

// The domain_rule as ddssec and as the product read it.
class Rules {
 public:
  Rules(const DomainRule& ours, const DomainRule& theirs) : ours_(ours), theirs_(theirs) {}

  std::optional<Loss> loss() const {
    std::vector<RankedExpression> all{kBracket};
    for (std::uint32_t i = 0; i < ours_.topic_rules.size(); ++i) {
      all.push_back({ours_.topic_rules[i].topic_expression, kOurs, i});
      all.push_back({theirs_.topic_rules[i].topic_expression, kTheirs, i});
    }
    const auto found = find_name_atoms(all);
    for (const auto& atom : found.atoms) {
      if (!is_name(atom)) continue;
      const auto ours = atom.rank_in(kOurs), theirs = atom.rank_in(kTheirs);
      if (ours == theirs || !theirs) continue;  // without a rule the product makes no endpoint
      if (auto loss = loss_of(atom.witness, ours, *theirs)) return loss;
    }
    if (found.is_complete) return std::nullopt;
    return Loss{changed(0), "there are too many expressions to tell what it protects"};
  }

 private:
  std::optional<Loss> loss_of(const std::string& topic, std::optional<std::uint32_t> ours,
                              std::uint32_t theirs) const {
    const auto* const protects = ours ? &ours_.topic_rules[*ours] : nullptr;
    const auto& applies = ours_.topic_rules[theirs];
    const auto changes = compare_topic_rules({ours_, ours_, protects, &applies});
    const auto less = std::ranges::find_if(changes, is_less);
    if (less == changes.end()) return std::nullopt;
    return Loss{changed(ours && is_changed(*ours) ? *ours : theirs),
                fmt::format("topic \"{}\" is under the topic_rule at line {}, with <{}> {} instead "
                            "of {}",
                            topic, applies.line, less->element, less->new_value, less->old_value)};
  }

  bool is_changed(std::size_t at) const {
    const auto& a = ours_.topic_rules[at];
    const auto& b = theirs_.topic_rules[at];
    return a.topic_expression != b.topic_expression || a.is_padded != b.is_padded;
  }
  // The first expression, from this one on, that the product reads differently.
  Text changed(std::size_t at) const {
    while (!is_changed(at)) at = (at + 1) % ours_.topic_rules.size();
    const auto& rule = ours_.topic_rules[at];
    return {rule.topic_expression, rule.line, rule.is_padded};
  }

  const DomainRule& ours_;
  const DomainRule& theirs_;
};

enum class NamesOf : std::uint8_t { topics, partitions };

// Calls `each` with each expression of the grant for those names.
template <class Each>
void each_expression(const Grant& grant, NamesOf names, Each&& each) {
  for (const auto& rule : grant.rules)
    for (const auto* list : {&rule.publish, &rule.subscribe})
      for (const auto& criteria : *list) {
        if (names == NamesOf::topics) std::ranges::for_each(criteria.topics, each);
        if (names == NamesOf::partitions && criteria.partitions)
          std::ranges::for_each(*criteria.partitions, each);
      }
}

// The grant as ddssec and as the product read it.
class Rights {
 public:
  Rights(const LoadedFolder& folder, const Settings& settings, const Grant& ours, Product product,
         Grant theirs)
      : folder_(folder),
        settings_(settings),
        product_(product),
        changed_(std::make_shared<const Permissions>(Permissions{.grants = {std::move(theirs)}})),
        ours_(folder.permissions.model, ours, settings.domain),
        theirs_(changed_, changed_->grants.front(), settings.domain) {}

  std::optional<Loss> loss() {
    auto partitions = samples(NamesOf::partitions);
    partitions.emplace_back();
    for (const auto& topic : samples(NamesOf::topics))
      for (const auto& partition : partitions)
        for (const auto action : {Action::publish, Action::subscribe})
          if (is_loss(action, topic, partition)) return loss_of(action, topic, partition);
    if (is_complete_) return std::nullopt;
    return Loss{any_changed(), "there are too many expressions to tell what it allows"};
  }

 private:
  static constexpr std::size_t kMaxSamples = 200;

  // Returns one name for each way in which both read the expressions. For topics the topic_rules
  // are included, because they may leave topics open.
  std::vector<std::string> samples(NamesOf names) {
    std::vector<RankedExpression> all{kBracket};
    std::uint32_t list = kWithBracket;
    const auto add = [&](const Text& text) { all.push_back({text.text, ++list, 0}); };
    each_expression(ours_.grant(), names, add);
    each_expression(theirs_.grant(), names, add);
    if (const auto* const domain = domain_rule(); domain != nullptr && names == NamesOf::topics)
      for (const auto& rule : domain->topic_rules)
        all.push_back({rule.topic_expression, kOurs, static_cast<std::uint32_t>(all.size())});
    std::vector<std::string> out;
    const auto found = find_name_atoms(all);
    for (const auto& atom : found.atoms)
      if (is_name(atom) && out.size() < kMaxSamples) out.push_back(atom.witness);
    is_complete_ = is_complete_ && found.is_complete && out.size() < kMaxSamples;
    return out;
  }

  bool is_loss(Action action, const std::string& topic, std::string_view partition) const {
    const std::string_view all[] = {partition};
    const Request request{.topic = topic, .partitions = all};
    return !ours_.judge(action, request).allowed && theirs_.judge(action, request).allowed &&
           judge_as(product_, ours_, settings_.domain, action, request).allowed &&
           !is_refused_otherwise(topic) && is_controlled(action, topic);
  }

  // Cyclone DDS makes no topic that the first rule with its name denies.
  bool is_refused_otherwise(const std::string& topic) const {
    if (product_ != Product::cyclonedds) return false;
    const auto* const rule = first_rule_naming(ours_.grant(), settings_.domain, topic);
    return rule != nullptr && !rule->allow;
  }

  const DomainRule* domain_rule() const {
    return folder_.governance.model ? folder_.governance.model->find(settings_.domain) : nullptr;
  }

  bool is_controlled(Action action, const std::string& topic) const {
    const auto* const domain = domain_rule();
    const auto* const rule =
        domain != nullptr ? topic_rule_as(Product::ddssec, *domain, topic) : nullptr;
    return rule == nullptr || (action == Action::publish ? rule->enable_write_access_control
                                                         : rule->enable_read_access_control);
  }

  Loss loss_of(Action action, const std::string& topic, const std::string& partition) const {
    Text reason;
    const auto find = [&](const std::string& name) {
      return [&](const Text& text) {
        if (reason.text.empty() &&
            matches_as(Product::ddssec, text, name) != matches_as(product_, text, name))
          reason = text;
      };
    };
    each_expression(ours_.grant(), NamesOf::topics, find(topic));
    each_expression(ours_.grant(), NamesOf::partitions, find(partition));
    return {reason, fmt::format("it allows {} topic \"{}\"{}, which ddssec refuses",
                                action == Action::publish ? "publishing" : "subscribing to", topic,
                                partition.empty() ? "" : " in partition \"" + partition + '"')};
  }

  Text any_changed() const {
    Text out;
    const auto find = [&](const Text& text) {
      if (out.text.empty() && (text.is_padded || !is_portable(text.text))) out = text;
    };
    each_expression(ours_.grant(), NamesOf::topics, find);
    each_expression(ours_.grant(), NamesOf::partitions, find);
    return out;
  }

  const LoadedFolder& folder_;
  const Settings& settings_;
  Product product_;
  bool is_complete_ = true;
  std::shared_ptr<const Permissions> changed_;
  CompiledGrant ours_, theirs_;
};

void report(const Loss& loss, Product product, const std::filesystem::path& document,
            const Settings& settings, Diagnosis& out) {
  Outcomes outcomes;
  (product == Product::cyclonedds ? outcomes.cyclonedds : outcomes.fastdds) = Outcome::unsafe;
  out.report(outcomes,
             {.rule = Rule::DOC107,
              .message = fmt::format(
                  "{} does not read \"{}\"{} as ddssec does: {}", name(product, settings.lineup),
                  loss.expression.text.substr(0, 256),
                  loss.expression.is_padded ? " between line breaks or blanks" : "", loss.because),
              .document = document,
              .line = loss.expression.line});
}

}  // namespace

void diagnose_readings(const LoadedFolder& folder, const Settings& settings, Diagnosis& out) {
  const auto* const rule =
      folder.governance.model ? folder.governance.model->find(settings.domain) : nullptr;
  const auto* const grant = grant_of(folder, settings.now);
  for (const auto& [product, stock] : kStockProductPairs) {
    if (const auto theirs = rule != nullptr ? rewritten_expressions(*rule, stock) : std::nullopt)
      if (const auto loss = Rules(*rule, *theirs).loss())
        report(*loss, product, folder.paths.governance, settings, out);
    if (auto theirs = grant != nullptr ? rewritten_expressions(*grant, stock) : std::nullopt)
      if (const auto loss = Rights(folder, settings, *grant, product, *std::move(theirs)).loss())
        report(*loss, product, folder.paths.permissions, settings, out);
  }
}

}  // namespace ddssec::governance::doctor
