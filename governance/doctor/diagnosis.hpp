// Finds everything that is wrong with a participant's folder, for each product, in one run.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/finding.hpp"
#include "base/ids.hpp"
#include "governance/doctor/loaded_folder.hpp"
#include "governance/doctor/product.hpp"

namespace ddssec::governance::doctor {

/// The rule of a finding; a document's rule is governance::GrantRule.
using ddssec::Rule;

/// One check, and its outcome for each product.
struct Check {
  Rule rule;
  std::string title;  ///< such as "permissions: signature"
  Outcomes outcomes = {};
  std::vector<Finding> findings = {};  ///< empty if there is nothing to report
};

/// The time and the domain in which the participant is to run.
struct Settings {
  WallTime now;
  DomainId domain = 0;
  /// The partitions of the endpoints of the two participants. An empty list means the
  /// partition "".
  std::vector<std::string> partitions = {};
  /// The party that must be able to write a topic that the other one reads. If none is set, either
  /// of them is enough.
  bool writes[2] = {false, false};
  /// The versions for which to predict.
  Lineup lineup = {};
  /// True if the participant may run on another machine: paths of its configurations that lead out
  /// of its folder, and libraries that are not on this machine, are warnings (DOC007).
  bool may_run_elsewhere = false;
};

/// All checks, in the order of a participant's start.
class Diagnosis {
 public:
  Diagnosis() = default;
  /// `lineup` has the versions that findings name.
  explicit Diagnosis(const Lineup& lineup) : lineup_(lineup) {}

  /// Adds a check without findings.
  void pass(Rule rule, std::string_view about = {});
  /// Adds a finding. Its products are filled in from the outcomes unless these are the same for
  /// all.
  void report(Outcomes outcomes, Finding finding, std::string_view about = {});
  /// Adds the checks of `other`. Checks that exist already get its outcomes and findings in
  /// addition.
  void append(Diagnosis other);

  const std::vector<Check>& checks() const { return checks_; }
  /// Returns the worst outcome of all checks, for each product.
  Outcomes outcomes() const;

 private:
  Check& check_for(Rule rule, std::string_view about);
  Lineup lineup_ = {};
  std::vector<Check> checks_;
};

/// Checks every part of the folder. A check that is impossible because another part is broken is
/// left out; the broken part is reported.
Diagnosis diagnose(const LoadedFolder& folder, const Settings& settings);

/// Finds topics that ddssec's reading of the expressions protects or refuses, and a stock product's
/// does not (DOC107). A part of diagnose(). Reports one finding for each product and document.
void diagnose_readings(const LoadedFolder& folder, const Settings& settings, Diagnosis& out);

/// The configuration that CYCLONEDDS_URI names.
struct ConfigurationInForce {
  std::string_view text;    ///< the text of cyclonedds_configuration()
  std::size_t inline_from;  ///< where the part in the variable itself begins
};

/// Checks whether a configuration of Cyclone DDS makes the participant's process read the files of
/// the folder. A configuration of another participant is ignored.
void diagnose_configuration_in_force(const LoadedFolder& folder,
                                     const ConfigurationInForce& in_force, const Settings& settings,
                                     Diagnosis& out);

/// As diagnose_configuration_in_force, for a file of profiles of Fast DDS, named by the
/// environment. One that is not of this participant is a warning if the participant has its own.
void diagnose_profile_in_force(const LoadedFolder& folder, const std::filesystem::path& file,
                               const Settings& settings, Diagnosis& out);

/// As diagnose_profile_in_force, for the file of profiles that Fast DDS reads in the working
/// directory. Its default participant replaces that of the file that the environment names
/// (measured with 2.9.1).
void diagnose_profile_of_working_directory(const LoadedFolder& folder, const Settings& settings,
                                           Diagnosis& out);

}  // namespace ddssec::governance::doctor
