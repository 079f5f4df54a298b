#include "governance/doctor/security_section.hpp"

#include <algorithm>
#include <span>
#include <string_view>

#include <fmt/format.h>

#include "base/text.hpp"
#include "governance/doctor/expanded_variables.hpp"

namespace ddssec::governance::doctor {
namespace {

constexpr std::string_view kAuthentication[] = {"library",
                                                "identityca",
                                                "identitycertificate",
                                                "privatekey",
                                                "password",
                                                "trustedcadirectory",
                                                "crl",
                                                "includeoptionalfields"};
constexpr std::string_view kCryptographic[] = {"library"};
constexpr std::string_view kAccessControl[] = {"library", "permissionsca", "governance",
                                               "permissions"};
constexpr std::string_view kLibrary[] = {"path", "initfunction", "finalizefunction"};

}  // namespace

// An element of <Security> that configures one plugin.
struct SecuritySection::Kind {
  std::string_view name;
  std::span<const std::string_view> children;
  std::optional<ConfiguredPlugin> EffectiveSecurity::*plugin;
};
constexpr SecuritySection::Kind SecuritySection::kKinds[] = {
    {"authentication", kAuthentication, &EffectiveSecurity::authentication},
    {"cryptographic", kCryptographic, &EffectiveSecurity::cryptographic},
    {"accesscontrol", kAccessControl, &EffectiveSecurity::access_control},
};

void SecuritySection::begin(const OpenElements& elements, const Markup::Token& token) {
  depth_ = elements.depth();
  is_second_ = out_.applies;
  out_.authentication = out_.cryptographic = out_.access_control = std::nullopt;
  out_.applies = true;
  findings_.refuse_attributes(token);
}

void SecuritySection::on_start_tag(const OpenElements& elements, const Markup::Token& token) {
  const auto level = elements.depth() - depth_;
  if (level == 1) return begin_plugin(token);
  if (kind_ == nullptr) return;
  if (level != 2 || std::ranges::find(kind_->children, token.name) == kind_->children.end())
    return add_unknown_element(token);
  auto& plugin = *(out_.*kind_->plugin);
  if (token.name == "library") return read_library(token, plugin);
  findings_.refuse_attributes(token);
  if (plugin.value(token.name) != nullptr) {
    findings_.add_problem(token.line, fmt::format("has <{}> twice", token.name));
    value_ = &(repeated_ = {{}, token.line});
    return;
  }
  plugin.values.push_back({token.name, {{}, token.line}});
  value_ = &plugin.values.back().second;
}

void SecuritySection::begin_plugin(const Markup::Token& token) {
  const auto* const found = std::ranges::find(kKinds, token.name, &Kind::name);
  kind_ = found == std::end(kKinds) ? nullptr : found;
  if (kind_ == nullptr) return add_unknown_element(token);
  if (out_.*kind_->plugin)
    findings_.add_problem(token.line,
                          fmt::format("has a second <{}> in one <Security>", token.name));
  out_.*kind_->plugin = ConfiguredPlugin{};
  findings_.refuse_attributes(token);
}

void SecuritySection::read_library(const Markup::Token& token, ConfiguredPlugin& plugin) {
  if (!plugin.library.empty()) findings_.add_problem(token.line, "has <library> twice");
  for (const auto& [name, value] : token.attributes)
    if (std::ranges::find(kLibrary, name) == std::end(kLibrary))
      findings_.add_unknown_attribute(token, name);
    else if (plugin.attribute(name) != nullptr)
      findings_.add_problem(token.line,
                            fmt::format("has the attribute {} of <library> twice", name));
    else
      plugin.library.push_back({name, {value, token.line}});
}

void SecuritySection::add_unknown_element(const Markup::Token& token) {
  findings_.add_problem(token.line,
                        fmt::format("has <{}> inside <Security>, which Cyclone DDS does not know",
                                    token.name.substr(0, 64)));
}

bool SecuritySection::on_text(const Markup::Token& token) {
  if (value_ == nullptr) return false;
  value_->text += token.name;
  return true;
}

void SecuritySection::on_end(const OpenElements& elements) {
  const auto& ended = elements.innermost();
  if (elements.depth() == depth_) {
    depth_ = 0;
    if (is_second_ && !out_.authentication)
      findings_.add_problem(ended.line, "has a second <Security> without <Authentication>");
  }
  if (value_ == nullptr) return;
  value_->text = std::string(trimmed(value_->text, kMarkupBlanks));
  if (ended.name == "includeoptionalfields") diagnose_switch(ended);
  value_ = nullptr;
}

// Measured: an empty value means the default.
void SecuritySection::diagnose_switch(const OpenElement& element) {
  const auto read = ascii_lower(expanded_variables(value_->text, domain_).value_or(""));
  if (!read.empty() && read != "true" && read != "false")
    findings_.add_problem(value_->line,
                          fmt::format("has the value \"{}\" for <{}>, which is true or false",
                                      value_->text.substr(0, 64), element.spelled));
}

}  // namespace ddssec::governance::doctor
