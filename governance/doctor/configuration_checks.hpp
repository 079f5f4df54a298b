// How configurations of Cyclone DDS are judged. For governance/doctor/ only.
#pragma once

#include <filesystem>
#include <string>

#include "base/text.hpp"
#include "governance/doctor/diagnosis.hpp"
#include "governance/doctor/effective_security.hpp"

namespace ddssec::governance::doctor {

/// A configuration, and the participant that it may be for.
struct ConfigurationInQuestion {
  std::string name;  ///< what sentences call it
  std::filesystem::path document;
  const LoadedFolder& folder;
  DomainId domain;
  const EffectiveSecurity& security;
};

/// DOC101, DOC102: whether a process that starts with it comes up, with the documents of the folder
/// in force. Which files it names is another matter (DOC008).
void check_effective_security(const ConfigurationInQuestion& question, Diagnosis& out);

}  // namespace ddssec::governance::doctor
