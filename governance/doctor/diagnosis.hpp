// What is wrong with a participant's folder, for each product: all of it in one run.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/finding.hpp"
#include "base/ids.hpp"
#include "governance/doctor/loaded_folder.hpp"
#include "governance/doctor/vendor.hpp"

namespace ddssec::governance::doctor {

/// What findings are by; a document's rule is governance::Rule.
using ddssec::Rule;

/// One thing that was looked at, and what each product makes of it.
struct Check {
  Rule rule;
  std::string title;  ///< such as "permissions: signature"
  Outcomes outcomes = {};
  std::vector<Finding> findings = {};  ///< empty: nothing to say
};

/// When and where the participant is to run.
struct Settings {
  WallTime now;
  DomainId domain = 0;
  /// Of the endpoints, where two participants meet; none: the partition "".
  std::vector<std::string> partitions = {};
  /// Which party has to be able to write a topic that the other reads; none: either of them.
  bool writes[2] = {false, false};
  /// The versions that are predicted.
  Lineup lineup = {};
};

/// Everything that was looked at, in the order of a participant's start.
class Diagnosis {
 public:
  Diagnosis() = default;
  /// Findings name these versions.
  explicit Diagnosis(const Lineup& lineup) : lineup_(lineup) {}

  /// Nothing is wrong with it.
  void pass(Rule rule, std::string_view about = {});
  /// Something is wrong. The finding's vendors are filled in from the outcomes, if it is not the
  /// same for all.
  void report(Outcomes outcomes, Finding finding, std::string_view about = {});
  /// Adds the other's checks behind these.
  void append(Diagnosis other);

  const std::vector<Check>& checks() const { return checks_; }
  /// The worst of all checks, for each product.
  Outcomes outcomes() const;

 private:
  Check& check_for(Rule rule, std::string_view about);
  Lineup lineup_ = {};
  std::vector<Check> checks_;
};

/// Looks at every piece of the folder. What cannot be judged because another piece is broken is
/// left out; that piece is reported.
Diagnosis diagnose(const LoadedFolder& folder, const Settings& settings);

/// Whether the configuration of Cyclone DDS that the environment names, its text, makes the
/// participant's process read the files of the folder. One of another participant says nothing.
void check_configuration_in_force(const LoadedFolder& folder, std::string_view text,
                                  const Settings& settings, Diagnosis& out);

}  // namespace ddssec::governance::doctor
