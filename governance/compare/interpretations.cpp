#include "governance/compare/interpretations.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include <fmt/format.h>

#include "governance/cyclonedds_subject.hpp"
#include "governance/dialect.hpp"
#include "governance/lint_findings.hpp"
#include "governance/subject_spelling.hpp"
#include "governance/xml.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::governance {
namespace {

// The largest number of expressions that are tried. Each may take some milliseconds.
constexpr std::size_t kMaxTried = 1'000;

// The constructs of one document, and the line of each one's first occurrence.
struct Constructs {
  std::map<std::string, int> expressions = {};
  // These three identify a note. The same words at another place, or about another value, change
  // what a product reads.
  using Place = std::tuple<std::string, std::string, std::string>;  // text, path, value
  std::map<Place, int> notes = {};
  bool has_all_notes = true;
  // Grants that Cyclone DDS applies to certificates of another subject, by the subjects of the
  // certificate and of the grant.
  std::map<std::pair<std::string, std::string>, MisappliedGrant> strays = {};
  // Subject names by which some stock product recognises no certificate.
  struct Subject {
    int line;
    std::string key;  // the same for every spelling
    SpellingProblem problem;
  };
  std::map<std::string, Subject> subjects = {};
  std::set<std::string> well_written = {};  // keys of the other subjects

  // True if the same products do not recognise that subject in this document either.
  bool has_problem(const Subject& subject) const {
    return std::ranges::any_of(subjects, [&](const auto& own) {
      return own.second.key == subject.key &&
             std::ranges::includes(own.second.problem.products, subject.problem.products);
    });
  }

  void add(const std::vector<Text>& texts) {
    for (const auto& text : texts) expressions.try_emplace(text.text, text.line);
  }
  void add(const std::vector<Note>& all) {
    // Notes about open ranges are left out, because the comparison reports these ranges itself.
    for (const auto& note : all)
      if (!is_open_range(note.kind))
        notes.try_emplace({note.text, note.path, note.value}, note.line);
    has_all_notes = all.size() < kMaxNotes;
  }
};

Constructs constructs_of(const Governance& document) {
  Constructs out;
  for (const auto& domain : document.domain_rules)
    for (const auto& topic : domain.topic_rules)
      out.expressions.try_emplace(topic.topic_expression, topic.line);
  out.add(document.notes);
  return out;
}

void add_subject(const Grant& grant, Constructs& out) {
  const auto name = pki::SubjectName::parse(grant.subject_name);
  if (!name) return;
  auto problem = misspelt(grant);
  if (!problem) problem = letters_beyond_ascii(grant);
  const auto text = (grant.subject_has_line_breaks ? "\n" : "") + grant.subject_name;
  if (!problem) out.well_written.insert(name->key());
  if (problem)
    out.subjects.try_emplace(text, Constructs::Subject{grant.line, name->key(), *problem});
}

// Relay elements are left out, because stock products ignore them. Tag expressions are left out,
// because stock products refuse them, and a note says so.
Constructs constructs_of(const Permissions& document) {
  Constructs out;
  for (const auto& grant : document.grants) add_subject(grant, out);
  for (const auto& grant : document.grants)
    for (const auto& rule : grant.rules)
      for (const auto* list : {&rule.publish, &rule.subscribe})
        for (const auto& criteria : *list) {
          out.add(criteria.topics);
          if (criteria.partitions) out.add(*criteria.partitions);
        }
  out.add(document.notes);
  return out;
}

class Collector {
 public:
  void add(const Constructs& own, const Constructs& other, bool is_new) {
    const auto begin = out_.all.size();
    for (const auto& [place, line] : own.notes)
      if (!other.notes.contains(place)) put({is_new, {}, std::get<0>(place), line});
    if (!own.has_all_notes) out_.is_complete = false;
    for (const auto& [subjects, stray] : own.strays)
      if (!other.strays.contains(subjects))
        put({.is_new = is_new,
             .expression = {},
             .sentence = to_sentence(stray),
             .line = stray.grant->line,
             .widens = true});
    for (const auto& [text, subject] : own.subjects)
      if (!other.subjects.contains(text))
        add_subject(subject, !other.has_problem(subject) && !own.well_written.contains(subject.key),
                    is_new);
    for (const auto& [text, line] : own.expressions)
      if (!other.expressions.contains(text)) add_expression(text, line, is_new);
    std::ranges::stable_sort(out_.all.begin() + static_cast<std::ptrdiff_t>(begin), out_.all.end(),
                             {}, &Interpretation::line);
  }
  Interpretations take() { return std::move(out_); }

 private:
  static std::string sentence_about(const SpellingProblem& problem) {
    if (problem.right.empty()) return problem.message;
    return fmt::format("{}: {} no certificate by it", problem.message,
                       problem.products.size() > 1            ? "Cyclone DDS and Fast DDS recognise"
                       : problem.products.front() == kCyclone ? "Cyclone DDS recognises"
                                                              : "Fast DDS recognises");
  }
  // A participant whose subject a product does not recognise has no rights there.
  void add_subject(const Constructs::Subject& subject, bool changes, bool is_new) {
    put({.is_new = is_new,
         .expression = {},
         .sentence = sentence_about(subject.problem),
         .line = subject.line,
         .widens = changes && !is_new,
         .narrows = changes && is_new});
  }
  void add_expression(const std::string& text, int line, bool is_new) {
    if (!is_suspect(text)) return;
    if (++tried_ > kMaxTried) {
      out_.is_complete = false;
      return;
    }
    const auto found = unportable(text, effort_);
    if (effort_.steps == 0) out_.is_complete = false;
    if (found && found->is_read_differently()) put({is_new, text, to_sentence(text, *found), line});
  }
  // All products read an expression without these characters alike.
  static bool is_suspect(const std::string& text) {
    return text.find_first_of("[]\\") != std::string::npos;
  }
  void put(Interpretation interpretation) {
    if (out_.all.size() < kMaxInterpretations)
      out_.all.push_back(std::move(interpretation));
    else
      out_.is_complete = false;
  }

  Interpretations out_;
  std::size_t tried_ = 0;
  SetEffort effort_{100'000'000};  // about a second
};

void add_strays(Constructs& out, const Permissions& document,
                std::span<const Permissions* const> both) {
  for (auto& stray : misapplied_grants(document, both))
    out.strays.try_emplace({stray.certificate, stray.grant->subject_name}, stray);
}

Interpretations compared(const Constructs& before, const Constructs& after) {
  Collector collector;
  collector.add(after, before, true);
  collector.add(before, after, false);
  return collector.take();
}

}  // namespace

Interpretations interpretations_of(const Governance& old_document, const Governance& new_document) {
  return compared(constructs_of(old_document), constructs_of(new_document));
}

Interpretations interpretations_of(const Permissions& old_document,
                                   const Permissions& new_document) {
  const Permissions* const both[] = {&old_document, &new_document};
  auto before = constructs_of(old_document), after = constructs_of(new_document);
  add_strays(before, old_document, both);
  add_strays(after, new_document, both);
  return compared(before, after);
}

}  // namespace ddssec::governance
