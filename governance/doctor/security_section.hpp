// Reads a <Security> of Cyclone DDS's configuration. For governance/doctor/ only.
#pragma once

#include <cstddef>

#include "governance/doctor/configuration_findings.hpp"
#include "governance/doctor/effective_security.hpp"
#include "governance/doctor/open_elements.hpp"

namespace ddssec::governance::doctor {

/// Stores what the <Security> elements that apply say about the three plugins. Each of them must be
/// complete (measured): what a former one said does not count.
///
/// The legal states are
///   closed -> open     a <Security> that applies begins
///   open -> in plugin  <Authentication>, <Cryptographic> or <AccessControl> begins
///   in plugin -> in value -> in plugin, for each element of the plugin except <Library>
///   in plugin -> open -> closed, at the end tags
class SecuritySection {
 public:
  /// Both objects must outlive it.
  SecuritySection(EffectiveSecurity& out, ConfigurationFindings& findings, DomainId domain)
      : out_(out), findings_(findings), domain_(domain) {}

  bool is_open() const { return depth_ != 0; }
  /// The innermost open element is a <Security> that applies.
  void begin(const OpenElements& elements, const Markup::Token& token);
  /// The innermost open element has begun in the section.
  void on_start_tag(const OpenElements& elements, const Markup::Token& token);
  /// Returns false if the text is not the value of an element of the section.
  bool on_text(const Markup::Token& token);
  /// The innermost open element ends.
  void on_end(const OpenElements& elements);

 private:
  struct Kind;
  static const Kind kKinds[];

  void begin_plugin(const Markup::Token& token);
  void read_library(const Markup::Token& token, ConfiguredPlugin& plugin);
  void add_unknown_element(const Markup::Token& token);
  void diagnose_switch(const OpenElement& element);

  EffectiveSecurity& out_;
  ConfigurationFindings& findings_;
  DomainId domain_;
  std::size_t depth_ = 0;            ///< the depth of the <Security>; 0 outside
  bool is_second_ = false;           ///< this is not the first <Security> that applies
  const Kind* kind_ = nullptr;       ///< the plugin; nullptr: none, or an unknown one
  ConfiguredText* value_ = nullptr;  ///< in an element of a plugin
  ConfiguredText repeated_;          ///< the text of an element that is there already
};

}  // namespace ddssec::governance::doctor
