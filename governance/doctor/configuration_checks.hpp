// Checks configurations of Cyclone DDS and of Fast DDS. For governance/doctor/ only.
#pragma once

#include <filesystem>
#include <string>

#include "base/text.hpp"
#include "governance/doctor/diagnosis.hpp"
#include "governance/doctor/effective_security.hpp"

namespace ddssec::governance::doctor {

/// A configuration, and the participant that it may belong to.
struct ConfigurationInQuestion {
  std::string name;  ///< its name in messages
  std::filesystem::path document;
  const LoadedFolder& folder;
  DomainId domain;
  const EffectiveSecurity& security;
};

/// DOC101, DOC102: checks that a process with this configuration starts, with the documents of the
/// folder in force. Which files it names is checked elsewhere (DOC008).
void check_effective_security(const ConfigurationInQuestion& question, Diagnosis& out);

/// A file of profiles of Fast DDS.
struct ProfileInQuestion {
  std::string name;  ///< its name in messages
  std::filesystem::path document;
  std::string_view text;
};

/// DOC101, DOC102: checks that a process that takes its default profile from the file starts, with
/// security. Measured with Fast DDS 2.9.1: without a default participant profile, and without or
/// with a misspelt plugin, it starts without security and says so only in its log.
void check_profile(const ProfileInQuestion& question, Diagnosis& out);

}  // namespace ddssec::governance::doctor
