// The domain that a participant's documents are for.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "governance/doctor/loaded_folder.hpp"

namespace ddssec::governance::doctor {

/// Domains in ascending order; no two of the ranges touch.
using Domains = std::vector<DomainRange>;

/// The domains that both the governance document and the allow rules of the participant's grant
/// cover; one of either if they have none in common; nothing if neither can be read.
Domains domains_of(const LoadedFolder& folder, WallTime now);

/// A domain, and whether others would have done as well.
struct DomainChoice {
  DomainId domain = 0;
  /// All that the documents name; nothing if they name none.
  Domains named = {};

  bool has_others() const { return !named.empty() && named.front().first != named.back().last; }
};

/// The domain that all of these participants' documents cover (one of any, if none is common to
/// all): domain 0 if that is one of several, else the lowest; 0 if no document names a domain.
DomainChoice choose_domain(std::span<const Domains> participants);

/// In ascending order, with no two that touch.
Domains normal(Domains ranges);

bool contains(const Domains& domains, DomainId id);

/// "0-5, 7": at most 128 characters or a little more, then "...".
std::string in_words(const Domains& domains);

}  // namespace ddssec::governance::doctor
