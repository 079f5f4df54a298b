// The <Security> element of a Cyclone DDS configuration that counts for one domain.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/ids.hpp"

namespace ddssec::governance::doctor {

/// A text of the configuration and the line that it stands in, from 1.
struct ConfiguredText {
  std::string text;
  int line = 0;
};

/// Authentication, Cryptographic or AccessControl.
struct ConfiguredPlugin {
  /// Attributes of <Library> by their names in lower case: path, initfunction, finalizefunction.
  std::vector<std::pair<std::string, ConfiguredText>> library = {};
  /// The other elements, by their names in lower case, without blanks around the value.
  std::vector<std::pair<std::string, ConfiguredText>> values = {};

  /// Nothing if the <Library> has no such attribute.
  const ConfiguredText* attribute(std::string_view name) const;
  /// Nothing if there is no such element.
  const ConfiguredText* value(std::string_view name) const;
};

/// What Cyclone DDS 0.10.2 and 0.10.5 make of a configuration for one domain. Measured with both:
/// tests/unit/governance_doctor/effective_security_test.cpp has the table. Of elements outside of
/// <Security> those directly below <CycloneDDS> and <Domain> are judged; of deeper ones an unknown
/// name or attribute is a doubt, and one value that is set twice a problem. Values are not judged
/// (DECISIONS.md).
struct EffectiveSecurity {
  /// What keeps a process from starting, as sentences without their subject.
  std::vector<ConfiguredText> problems = {};
  /// What keeps a process of 0.10.2 and 0.10.5 from starting, and of another version maybe not.
  std::vector<ConfiguredText> doubts = {};
  /// A <Security> that counts for the domain.
  bool is_there = false;
  /// The Id of a <Domain> with a <Security> that counts for another domain; empty: there is none.
  std::string other_domain = {};
  std::optional<ConfiguredPlugin> authentication = {};
  std::optional<ConfiguredPlugin> cryptographic = {};
  std::optional<ConfiguredPlugin> access_control = {};
};

/// Where a configuration stands.
enum class ConfigurationPlace : std::uint8_t {
  file,      ///< one file: a whole document
  variable,  ///< CYCLONEDDS_URI: also several documents, or parts of one without end tags
};

EffectiveSecurity effective_security(std::string_view text, DomainId domain,
                                     ConfigurationPlace place);

}  // namespace ddssec::governance::doctor
