// Builds a grant from a list of rights.
#pragma once

#include <string>
#include <vector>

#include "governance/model.hpp"
#include "pki/certificate.hpp"

namespace ddssec::governance {

/// The rights as lists of expressions; everything that no list allows is denied.
struct Rights {
  std::vector<DomainRange> domains = {};
  std::vector<std::string> publish = {};
  std::vector<std::string> subscribe = {};
  std::vector<std::string> deny_publish = {};
  std::vector<std::string> deny_subscribe = {};
  /// The partitions in which the topics are allowed. If empty, only entities without partitions are
  /// allowed. Denials apply in every partition.
  std::vector<std::string> partitions = {};
};

/// Returns a grant for the certificate's subject, in the one spelling that every product accepts.
/// Denials come before allow rules, because the first rule that matches decides. An allow rule
/// without topics comes before the denials, and lets the participant join.
Grant grant_of(std::string name, const pki::Certificate& certificate, const Rights& rights,
               Validity validity);

}  // namespace ddssec::governance
