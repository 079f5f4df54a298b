// Finds the <Security> element of a Cyclone DDS configuration that applies to one domain.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/ids.hpp"

namespace ddssec::governance::doctor {

/// A text of the configuration and its line, from 1.
struct ConfiguredText {
  std::string text;
  int line = 0;
};

/// The settings of one plugin: Authentication, Cryptographic or AccessControl.
struct ConfiguredPlugin {
  /// Attributes of <Library> by their names in lower case: path, initfunction, finalizefunction.
  std::vector<std::pair<std::string, ConfiguredText>> library = {};
  /// The other elements, by their names in lower case; values without surrounding blanks.
  std::vector<std::pair<std::string, ConfiguredText>> values = {};

  /// Returns the attribute, or nullptr if the <Library> has none of this name.
  const ConfiguredText* attribute(std::string_view name) const;
  /// Returns the element, or nullptr if there is none.
  const ConfiguredText* value(std::string_view name) const;
};

/// How Cyclone DDS 0.10.2 and 0.10.5 read a configuration for one domain. Measured with both: the
/// table is in tests/unit/governance_doctor/effective_security_test.cpp. Outside of <Security>,
/// elements directly below <CycloneDDS> and <Domain> are checked. In deeper elements an unknown
/// name or attribute is a doubt, and a single value that is set twice is a problem. Values are not
/// checked (docs/decisions).
struct EffectiveSecurity {
  /// Reasons why a process does not start, as sentences without their subject.
  std::vector<ConfiguredText> problems = {};
  /// Reasons why a process with 0.10.2 or 0.10.5 does not start; another version may start.
  std::vector<ConfiguredText> doubts = {};
  /// True if a <Security> applies to the domain.
  bool applies = false;
  /// The Id of a <Domain> with a <Security> that applies to another domain; empty if there is none.
  std::string other_domain = {};
  std::optional<ConfiguredPlugin> authentication = {};
  std::optional<ConfiguredPlugin> cryptographic = {};
  std::optional<ConfiguredPlugin> access_control = {};
};

/// The source of a configuration.
enum class ConfigurationPlace : std::uint8_t {
  file,      ///< one file: a whole document
  variable,  ///< CYCLONEDDS_URI: also several documents, or parts of one without end tags
};

/// Returns the settings for the domain. The text from `inline_from` on, after the texts of the
/// files, is in the variable itself. Only there end tags may be missing or have no name.
EffectiveSecurity effective_security(std::string_view text, DomainId domain,
                                     ConfigurationPlace place, std::size_t inline_from = 0);

}  // namespace ddssec::governance::doctor
