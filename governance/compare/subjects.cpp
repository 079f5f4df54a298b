#include "governance/compare/subjects.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "governance/expression_text.hpp"
#include "governance/topic_sets.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::governance {
namespace {

// The largest number of steps for comparing sets of grants with kinds of values. Beyond that the
// answer is not exact.
constexpr std::size_t kMaxSteps = 20'000'000;
// The largest number of grants of one shape that are tried.
constexpr std::size_t kMaxForms = 4'000;

// The expression that one text between slashes must match. Only a slash matches a slash
// (FNM_PATHNAME), so the texts of a value are independent of each other.
using Segments = std::vector<std::string>;

// A grant as attributes in a fixed order: RDN by RDN, within an RDN by type.
struct Form {
  std::size_t grant;       // number, of both documents together
  std::string shape;       // types and numbers of segments: other shapes are other subjects
  Segments segments = {};  // the segments of all attributes
};

Segments segments_of(const std::string& value, bool is_expression) {
  if (!is_expression) {
    Segments out = {""};
    for (const char c : value) {
      if (c == '/')
        out.emplace_back();
      else
        out.back() += expression_of(std::string_view(&c, 1));
    }
    return out;
  }
  const Pattern pattern(value, Pattern::Syntax::subject);
  if (pattern.is_literal()) return segments_of(pattern.text(), false);
  Segments out = {""};
  for (const auto& step : pattern.steps()) {
    if (step.kind == Pattern::Kind::character && step.character == '/')
      out.emplace_back();
    else
      out.back() += expression_of(pattern, step);
  }
  return out;
}

bool has_repeated_type(const pki::Rdn& rdn) {
  std::set<std::string_view> types;
  return !std::ranges::all_of(rdn, [&](const auto& a) { return types.insert(a.type).second; });
}

Form form_of(const std::vector<pki::Rdn>& rdns, bool is_expression, std::size_t grant) {
  Form out{.grant = grant, .shape = {}};
  for (auto rdn : rdns) {
    std::ranges::stable_sort(rdn, {}, &pki::NameAttribute::type);
    out.shape += ',';
    for (const auto& [type, value] : rdn) {
      auto segments = segments_of(value, is_expression);
      out.shape += '+' + type + '/' + std::to_string(segments.size());
      std::ranges::move(segments, std::back_inserter(out.segments));
    }
  }
  return out;
}

// The numbers of the forms that match so far.
using Alive = std::vector<std::uint32_t>;

// Finds every set of forms of one shape that one subject matches together.
class ShapeSearch {
 public:
  explicit ShapeSearch(std::vector<Form> forms) : forms_(std::move(forms)) {}

  // Empty if there are too many.
  std::optional<std::set<Alive>> run(std::size_t& steps) {
    if (forms_.size() > kMaxForms) return std::nullopt;
    Alive all(forms_.size());
    for (std::uint32_t i = 0; i < forms_.size(); ++i) all[i] = i;
    std::set<Alive> alive = {all};
    for (std::size_t at = 0; at < forms_.front().segments.size(); ++at) {
      const auto kinds = kinds_at(at);
      if (!kinds) return std::nullopt;
      std::set<Alive> next;
      for (const auto& before : alive) {
        for (const auto& kind : *kinds) {
          steps += before.size() + 1;
          if (steps > kMaxSteps) return std::nullopt;
          Alive both;
          std::ranges::set_intersection(before, kind, std::back_inserter(both));
          if (!both.empty()) next.insert(std::move(both));
        }
      }
      alive = std::move(next);
    }
    return alive;
  }

 private:
  // For each kind of text at a place, the forms that match it.
  std::optional<std::vector<Alive>> kinds_at(std::size_t at) const {
    std::map<std::string_view, std::uint32_t> numbers;
    std::vector<RankedExpression> expressions;
    const auto number_of = [&](std::string_view text) {
      const auto next = static_cast<std::uint32_t>(numbers.size());
      const auto [entry, is_new] = numbers.try_emplace(text, next);
      if (is_new) expressions.push_back({text, next, 0});
      return entry->second;
    };
    const auto slash = number_of("*/*");
    std::vector<std::uint32_t> own;
    for (const auto& form : forms_) own.push_back(number_of(form.segments[at]));
    const auto atoms = name_atoms(expressions);
    if (!atoms) return std::nullopt;
    std::vector<Alive> out;
    for (const auto& atom : *atoms) {
      if (atom.rank_in(slash)) continue;
      Alive forms;
      for (std::uint32_t i = 0; i < forms_.size(); ++i)
        if (atom.rank_in(own[i])) forms.push_back(i);
      if (!forms.empty()) out.push_back(std::move(forms));
    }
    return out;
  }

  std::vector<Form> forms_;
};

class Finder {
 public:
  Finder(const Permissions& old_document, const Permissions& new_document)
      : old_count_(old_document.grants.size()) {
    for (const auto* document : {&old_document, &new_document})
      for (const auto& grant : document->grants) add(grant);
  }

  Subjects run() {
    for (auto& [shape, forms] : by_shape_) {
      const bool plain = std::ranges::none_of(
          forms, [&](const Form& form) { return grants_[form.grant]->subject_is_expression; });
      plain ? group_by_name(forms) : search(std::move(forms));
    }
    Subjects out{.is_exact = is_exact_};
    for (const auto& numbers : sets_) {
      Subject subject;
      for (const auto number : numbers)
        (number < old_count_ ? subject.old_grants : subject.new_grants).push_back(grants_[number]);
      out.all.push_back(std::move(subject));
    }
    return out;
  }

 private:
  using Numbers = std::vector<std::size_t>;

  void add(const Grant& grant) {
    const auto number = grants_.size();
    grants_.push_back(&grant);
    // A subject that is not a name belongs to no certificate.
    const auto name = pki::SubjectName::parse(grant.subject_name);
    if (!name) return;
    auto rdns = name->rdns();
    if (grant.subject_is_expression && std::ranges::any_of(rdns, has_repeated_type))
      is_exact_ = false;
    auto forward = form_of(rdns, grant.subject_is_expression, number);
    std::ranges::reverse(rdns);
    auto backward = form_of(rdns, grant.subject_is_expression, number);
    // A name and its reverse are the same name, so only one of each pair of shapes is examined.
    const bool is_palindrome = forward.shape == backward.shape;
    if (backward.shape < forward.shape) std::swap(forward, backward);
    auto& forms = by_shape_[forward.shape];
    forms.push_back(forward);
    if (is_palindrome && backward.segments != forward.segments) forms.push_back(backward);
  }

  // Groups subjects without expressions, which are simply names.
  void group_by_name(const std::vector<Form>& forms) {
    std::map<std::string, Numbers> names;
    for (const auto& form : forms) {
      const auto name = pki::SubjectName::parse(grants_[form.grant]->subject_name);
      auto& numbers = names[name->key()];
      if (numbers.empty() || numbers.back() != form.grant) numbers.push_back(form.grant);
    }
    for (auto& [key, numbers] : names) sets_.insert(std::move(numbers));
  }

  void search(std::vector<Form> forms) {
    std::vector<std::size_t> numbers;
    for (const auto& form : forms) numbers.push_back(form.grant);
    const auto found = ShapeSearch(std::move(forms)).run(steps_);
    if (!found) {
      is_exact_ = false;
      for (const auto number : numbers) sets_.insert({number});
      return;
    }
    for (const auto& alive : *found) {
      Numbers grants;
      for (const auto form : alive) grants.push_back(numbers[form]);
      const auto repeated = std::ranges::unique(grants);
      grants.erase(repeated.begin(), repeated.end());
      sets_.insert(std::move(grants));
    }
  }

  std::size_t old_count_;
  Grants grants_;
  std::map<std::string, std::vector<Form>> by_shape_;
  std::set<Numbers> sets_;  // in the order of the first grants
  std::size_t steps_ = 0;
  bool is_exact_ = true;
};

// True if the expressions match the same texts, except texts with a slash.
bool match_the_same(std::string_view a, std::string_view b) {
  if (a == b) return true;
  constexpr SetLimits kLimits{.states = 2'000, .steps = 1'000'000};
  const auto within = [&](std::string_view inner, std::string_view outer) {
    const std::string_view in[] = {inner};
    const std::string_view out[] = {outer, "*/*"};
    return contained(in, out, kLimits).kind == SetAnswer::Kind::yes;
  };
  return within(a, b) && within(b, a);
}

bool is_the_same(const Form& a, const Form& b) {
  return a.shape == b.shape && std::ranges::equal(a.segments, b.segments, match_the_same);
}

}  // namespace

Subjects subjects_of(const Permissions& old_document, const Permissions& new_document) {
  return Finder(old_document, new_document).run();
}

const Grant& spelling_of(const Subject& subject) {
  for (const auto* grants : {&subject.new_grants, &subject.old_grants})
    for (const Grant* grant : *grants)
      if (!grant->subject_is_expression) return *grant;
  return *(subject.new_grants.empty() ? subject.old_grants : subject.new_grants).front();
}

bool same_subjects(const Grant& a, const Grant& b) {
  const auto one = pki::SubjectName::parse(a.subject_name);
  const auto other = pki::SubjectName::parse(b.subject_name);
  if (!one || !other) return false;
  if (!a.subject_is_expression && !b.subject_is_expression) return one->key() == other->key();
  auto rdns = other->rdns();
  const auto own = form_of(one->rdns(), a.subject_is_expression, 0);
  const auto forward = form_of(rdns, b.subject_is_expression, 0);
  std::ranges::reverse(rdns);
  return is_the_same(own, forward) || is_the_same(own, form_of(rdns, b.subject_is_expression, 0));
}

}  // namespace ddssec::governance
