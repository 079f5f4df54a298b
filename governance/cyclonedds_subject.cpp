#include "governance/cyclonedds_subject.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "governance/lint_findings.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::governance {
namespace {

std::string_view type_of(std::string_view piece) { return piece.substr(0, piece.find('=')); }

// A subject as in a certificate, and a key that is the same for every spelling.
struct NamedSubject {
  std::string text;
  std::string key;
  auto operator<=>(const NamedSubject&) const = default;
};

std::optional<NamedSubject> subject_of(const Grant& grant) {
  if (grant.subject_is_expression) return std::nullopt;
  const auto name = pki::SubjectName::parse(grant.subject_name);
  if (!name) return std::nullopt;
  return NamedSubject{rfc2253(*name, name->is_root_first()), name->key()};
}

}  // namespace

// Splits like strtok: there are no escapes, and no empty pieces between separators.
std::vector<std::string_view> pieces_for_cyclonedds(std::string_view text) {
  constexpr std::string_view kSeparators = ",/|";
  std::vector<std::string_view> out;
  while (!text.empty()) {
    const auto end = std::min(text.find_first_of(kSeparators), text.size());
    if (end > 0) out.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return out;
}

// If several pieces of the grant have the same type, the first one counts.
bool cyclonedds_applies_grant(std::string_view grant, std::string_view certificate) {
  const auto said = pieces_for_cyclonedds(grant);
  return std::ranges::all_of(pieces_for_cyclonedds(certificate), [&](std::string_view piece) {
    const auto found = std::ranges::find(said, type_of(piece), type_of);
    return found != said.end() && *found == piece;
  });
}

GrantsForCyclone::GrantsForCyclone(const Permissions& document) {
  for (const auto& grant : document.grants)
    for (const auto piece : pieces_for_cyclonedds(grant.subject_name)) {
      auto& having = by_piece_[piece];
      if (having.empty() || having.back() != &grant) having.push_back(&grant);
    }
}

const Grant* GrantsForCyclone::applied_grant_for(std::string_view certificate) const {
  // A grant that applies has every piece, so the shortest list of grants with one piece is
  // searched.
  const std::vector<const Grant*>* fewest = nullptr;
  for (const auto piece : pieces_for_cyclonedds(certificate)) {
    const auto having = by_piece_.find(piece);
    if (having == by_piece_.end()) return nullptr;
    if (fewest == nullptr || having->second.size() < fewest->size()) fewest = &having->second;
  }
  if (fewest == nullptr) return nullptr;
  const auto taken = std::ranges::find_if(*fewest, [&](const Grant* grant) {
    return cyclonedds_applies_grant(grant->subject_name, certificate);
  });
  return taken == fewest->end() ? nullptr : *taken;
}

namespace {

// The grants of a document for one subject, in any spelling.
struct OwnGrants {
  const Grant* first = nullptr;
  std::size_t count = 0;
};
using OwnGrantsOf = std::map<std::string_view, OwnGrants>;

// The subjects of both documents by a key that is the same for every spelling.
struct SubjectsOfBoth {
  std::map<std::string, std::vector<std::string>> texts;  // the spellings in certificates
  OwnGrantsOf before, after;

  SubjectsOfBoth(const Permissions& old_document, const Permissions& new_document) {
    add(old_document, before);
    add(new_document, after);
  }

 private:
  void add(const Permissions& document, OwnGrantsOf& own) {
    for (const auto& grant : document.grants) {
      const auto subject = subject_of(grant);
      if (!subject) continue;
      auto& [key, all] = *texts.try_emplace(subject->key).first;
      if (std::ranges::find(all, subject->text) == all.end()) all.push_back(subject->text);
      auto& grants = own[key];
      if (grants.count++ == 0) grants.first = &grant;
    }
  }
};

// True if ddssec also uses that grant, and no other.
bool is_the_only_one(const OwnGrantsOf& own, const std::string& key, const Grant* taken) {
  const auto found = own.find(key);
  if (found == own.end()) return taken == nullptr;
  return taken == found->second.first && found->second.count == 1;
}

void add_as(const std::string& subject, const Grant* taken, Permissions& out) {
  if (taken == nullptr) return;
  out.grants.push_back(*taken);
  out.grants.back().subject_name = subject;
}

}  // namespace

std::vector<CycloneDdsDocuments> applied_by_cyclonedds(const Permissions& old_document,
                                                       const Permissions& new_document) {
  const GrantsForCyclone before(old_document), after(new_document);
  std::vector<CycloneDdsDocuments> out;
  bool is_other = false;
  const SubjectsOfBoth subjects(old_document, new_document);
  for (const auto& [key, texts] : subjects.texts) {
    if (out.size() < texts.size()) out.resize(texts.size());
    for (std::size_t i = 0; i < texts.size(); ++i) {
      const auto* const o = before.applied_grant_for(texts[i]);
      const auto* const n = after.applied_grant_for(texts[i]);
      is_other |=
          !is_the_only_one(subjects.before, key, o) || !is_the_only_one(subjects.after, key, n);
      add_as(texts[i], o, out[i].before);
      add_as(texts[i], n, out[i].after);
    }
  }
  if (!is_other) out.clear();
  return out;
}

std::vector<MisappliedGrant> misapplied_grants(const Permissions& document,
                                               std::span<const Permissions* const> subjects) {
  std::set<std::string> own;
  for (const auto& grant : document.grants)
    if (auto subject = subject_of(grant)) own.insert(std::move(subject->key));
  const GrantsForCyclone grants(document);
  std::set<NamedSubject> seen;
  std::vector<MisappliedGrant> out;
  for (const auto* each : subjects)
    for (const auto& grant : each->grants) {
      const auto subject = subject_of(grant);
      if (!subject || !seen.insert(*subject).second) continue;
      const auto* const taken = grants.applied_grant_for(subject->text);
      if (taken == nullptr) continue;
      const auto its = subject_of(*taken);
      if (!its || its->key != subject->key)
        out.push_back({taken, subject->text, own.contains(subject->key)});
    }
  return out;
}

std::string to_sentence(const MisappliedGrant& stray) {
  return fmt::format(
      "Cyclone DDS gives a certificate of {} the rights of {}: the grant {}, and all attributes of "
      "the certificate are among its own",
      in_quotes(stray.certificate), in_quotes(stray.grant->subject_name),
      stray.has_own ? "stands before the certificate's own" : "is the first that fits");
}

}  // namespace ddssec::governance
