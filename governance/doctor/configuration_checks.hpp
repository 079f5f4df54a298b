// Checks configurations of Cyclone DDS and of Fast DDS. For governance/doctor/ only.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.hpp"
#include "governance/doctor/diagnosis.hpp"
#include "governance/doctor/effective_security.hpp"

namespace ddssec::governance::doctor {

/// A configuration, and the participant that it may belong to.
struct CheckedConfiguration {
  std::string name;  ///< its name in messages
  std::filesystem::path document;
  const LoadedFolder& folder;
  DomainId domain;
  const EffectiveSecurity& security;
  bool may_run_elsewhere = false;  ///< see Settings
};

/// The remark in a finding about a path that may be right on another machine.
inline constexpr std::string_view kIfElsewhere =
    "if this folder is for another machine, that is as it should be, and ddssec doctor judges it "
    "there";

/// Checks that a process with this configuration starts, with the documents of the folder in force
/// (DOC101, DOC102). Which files it names is checked elsewhere (DOC008).
void diagnose_effective_security(const CheckedConfiguration& question, Diagnosis& out);

/// A file of profiles of Fast DDS.
struct CheckedProfile {
  std::string name;  ///< its name in messages
  std::filesystem::path document;
  std::string_view text;
  Version version;  ///< version of the Fast DDS that is to read it
};

/// Names and values in document order, including the blanks around them.
using ProfileProperties = std::vector<std::pair<std::string, std::string>>;

/// Returns the properties of the default participant profile; empty if there is none, or if the
/// text is not well-formed.
std::optional<ProfileProperties> properties_of_profile(std::string_view text);

/// False if the text is well-formed and no <participant> in it has is_default_profile: it cannot
/// change the participant that another file describes.
bool may_set_default_participant(std::string_view text);

/// Checks that a process that takes its default profile from the file starts, with security
/// (DOC101, DOC102, DOC108). Measured with Fast DDS 2.9.1: without a default participant profile,
/// and without or with a misspelt plugin, it starts without security and says so only in its log. A
/// file with a part that is not known to be accepted counts as one that may do the same
/// (fastdds_elements.hpp).
void diagnose_profile(const CheckedProfile& question, Diagnosis& out);

}  // namespace ddssec::governance::doctor
