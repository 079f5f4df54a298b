// What a reader of Cyclone DDS's configuration finds wrong. For governance/doctor/ only.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "governance/doctor/effective_security.hpp"
#include "governance/doctor/markup.hpp"

namespace ddssec::governance::doctor {

/// Adds problems and doubts to a result, which must outlive it: the first kMax of each, because a
/// text of 1 MiB could have hundreds of thousands.
class ConfigurationFindings {
 public:
  static constexpr std::size_t kMax = 100;

  explicit ConfigurationFindings(EffectiveSecurity& out) : out_(out) {}

  bool has_problems() const { return !out_.problems.empty(); }
  /// Adds a reason why the process does not start, as a sentence without its subject.
  void add_problem(int line, std::string what) { add_to(out_.problems, line, std::move(what)); }
  /// Adds a reason why it may not start: other versions may accept it.
  void add_doubt(int line, std::string what) { add_to(out_.doubts, line, std::move(what)); }
  /// Adds the problem that Cyclone DDS does not know the attribute.
  void add_unknown_attribute(const Markup::Token& token, std::string_view name) {
    add_problem(token.line,
                fmt::format("has the attribute {} in <{}>, which Cyclone DDS does not know",
                            name.substr(0, 64), token.name.substr(0, 64)));
  }
  /// Adds this problem for each attribute.
  void refuse_attributes(const Markup::Token& token) {
    for (const auto& [name, value] : token.attributes) add_unknown_attribute(token, name);
  }

 private:
  static void add_to(std::vector<ConfiguredText>& findings, int line, std::string what) {
    if (findings.size() < kMax) findings.push_back({std::move(what), line});
  }

  EffectiveSecurity& out_;
};

}  // namespace ddssec::governance::doctor
