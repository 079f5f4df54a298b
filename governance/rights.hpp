// What a participant is to be allowed, as a grant.
#pragma once

#include <string>
#include <vector>

#include "governance/model.hpp"
#include "pki/certificate.hpp"

namespace ddssec::governance {

/// Lists of expressions; what no list allows is denied.
struct Rights {
  std::vector<DomainRange> domains = {};
  std::vector<std::string> publish = {};
  std::vector<std::string> subscribe = {};
  std::vector<std::string> deny_publish = {};
  std::vector<std::string> deny_subscribe = {};
  /// For what is allowed; none = only entities without partitions. Denials hold in every partition.
  std::vector<std::string> partitions = {};
};

/// A grant for the certificate's subject, in the one spelling that every product takes. Denials
/// come before what is allowed: the first rule that matches decides. Before denials there is an
/// allow rule without topics, which lets the participant join.
Grant grant_of(std::string name, const pki::Certificate& certificate, const Rights& rights,
               Validity validity);

}  // namespace ddssec::governance
