// Finds the domains that a participant's documents cover.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "governance/doctor/loaded_folder.hpp"

namespace ddssec::governance::doctor {

/// Domains in ascending order; no two of the ranges touch.
using Domains = std::vector<DomainRange>;

/// Returns the domains that both the governance document and the allow rules of the participant's
/// grant cover. If they have none in common, returns one domain of the governance document, because
/// all participants share that. Empty if neither can be read.
Domains domains_of(const LoadedFolder& folder, WallTime now);

/// The domains of the two documents, if they have none in common: the participant can then start in
/// no domain.
struct Contradiction {
  Domains governed;
  Domains granted;
  int line_of_governance = 0;  ///< line of the first <domains> in each document
  int line_of_permissions = 0;
};
/// Returns the contradiction. Empty if the documents have a domain in common, or if either one
/// cannot be read.
std::optional<Contradiction> contradiction_of(const LoadedFolder& folder, WallTime now);

/// Additional texts about documents that have no domain in common. They are empty if the documents
/// have one.
struct MismatchTexts {
  std::string words;
  std::string hint;
};
MismatchTexts mismatch_texts(const LoadedFolder& folder, WallTime now);

/// A chosen domain, and the alternatives.
struct DomainChoice {
  DomainId domain = 0;
  /// All domains that the documents name; empty if they name none.
  Domains named = {};

  bool has_others() const { return !named.empty() && named.front().first != named.back().last; }
};

/// Chooses a domain that the documents of all these participants cover. If no domain is common to
/// all, it chooses among the domains of any. The choice is domain 0 if that is one of several,
/// otherwise the lowest; 0 if no document names a domain.
DomainChoice choose_domain(std::span<const Domains> participants);

/// Returns the same domains in ascending order, with no two ranges that touch.
Domains merged(Domains ranges);

bool contains(const Domains& domains, DomainId id);

/// Returns a text such as "0-5, 7": at most 128 characters or a little more, then "...".
std::string to_text(const Domains& domains);

}  // namespace ddssec::governance::doctor
