// Domains and domain tags, divided where two documents distinguish them.
#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "governance/compare/name_kinds.hpp"
#include "governance/domain_cuts.hpp"
#include "governance/model.hpp"

namespace ddssec::governance {

/// Every domain of `domains` with every tag of `tags`.
struct DomainScope {
  std::vector<DomainRange> domains = {};
  /// False if the documents name no tags except "", the default tag of participants.
  bool has_tags = false;
  NameSet tags = {};
};

/// Cells with the same answer.
template <class Answer>
struct DomainRegion {
  Answer answer;
  DomainScope scope;
};

/// All domains and domain tags, divided so that each part is wholly inside or outside each of the
/// given sets.
class DomainSpace {
 public:
  /// Makes the space. Empty if there are more tags and tag expressions than can be compared.
  static std::optional<DomainSpace> of(const std::vector<const DomainSet*>& sets);

  /// Calls `answer_of(id, tag)` for all cells and combines them into scopes: no cell is in two
  /// scopes, and all cells of a scope have its answer. Answers must be ordered.
  template <class AnswerOf>
  auto regions(const AnswerOf& answer_of) const {
    using Answer = decltype(answer_of(DomainId{}, std::string()));
    std::vector<DomainRegion<Answer>> out;
    std::map<std::pair<Answer, std::vector<NameKinds::Kind>>, std::size_t> known;
    for (const auto& piece : cuts_.pieces()) {
      std::map<Answer, std::vector<NameKinds::Kind>> of_piece;
      for (NameKinds::Kind tag = 0; tag < tags_.size(); ++tag)
        of_piece[answer_of(piece.first, tags_.example(tag))].push_back(tag);
      for (auto& [answer, kinds] : of_piece) {
        const auto [entry, is_new] = known.try_emplace({answer, kinds}, out.size());
        if (is_new) out.push_back({answer, {{}, has_tags_, tags_.describe(kinds)}});
        out[entry->second].scope.domains.push_back(piece);
      }
    }
    for (auto& region : out) region.scope.domains = joined(std::move(region.scope.domains));
    return out;
  }

 private:
  explicit DomainSpace(NameKinds tags) : tags_(std::move(tags)) {}

  DomainCuts cuts_;
  NameKinds tags_;
  bool has_tags_ = false;
};

}  // namespace ddssec::governance
