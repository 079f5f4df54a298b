// Checks whether Cyclone DDS would start with a configuration, and with security.
#include <array>
#include <utility>

#include <fmt/format.h>

#include "governance/doctor/configuration_checks.hpp"
#include "governance/doctor/expanded_variables.hpp"
#include "governance/doctor/host_plugins.hpp"

namespace ddssec::governance::doctor {
namespace {

constexpr Outcomes kCycloneFails{.cyclonedds = Outcome::fail, .ddssec = Outcome::fail};

// The requirements of Cyclone DDS 0.10.2 for a plugin's element.
struct PluginRequirements {
  std::string_view element;
  std::optional<ConfiguredPlugin> EffectiveSecurity::*plugin;
  std::string_view stock;  // the plugin's library, which is the default
  std::string_view ours;   // the library of ddssec under its own name
  std::string_view init;
  std::string_view finalize;
  // The values as people write them. They are compared in lower case.
  std::array<std::string_view, 3> values;
};
constexpr PluginRequirements kExpected[] = {
    {"Authentication",
     &EffectiveSecurity::authentication,
     "dds_security_auth",
     "ddssec_authentication",
     "init_authentication",
     "finalize_authentication",
     {"IdentityCA", "IdentityCertificate", "PrivateKey"}},
    {"Cryptographic",
     &EffectiveSecurity::cryptographic,
     "dds_security_crypto",
     "ddssec_cryptography",
     "init_crypto",
     "finalize_crypto",
     {}},
    {"AccessControl",
     &EffectiveSecurity::access_control,
     "dds_security_ac",
     "ddssec_access_control",
     "init_access_control",
     "finalize_access_control",
     {"PermissionsCA", "Governance", "Permissions"}},
};

class Checks {
 public:
  Checks(const CheckedConfiguration& question, Diagnosis& out)
      : question_(question), security_(question.security), out_(out) {}

  void run() {
    out_.pass(Rule::DOC101);
    out_.pass(Rule::DOC102);
    for (const auto& problem : security_.problems)
      refuse(problem.line, fmt::format("{}, so that Cyclone DDS does not start", problem.text));
    for (const auto& doubt : security_.doubts) warn(doubt);
    if (!security_.problems.empty()) return;
    if (!security_.applies) return diagnose_absence();
    if (!security_.authentication)
      return refuse(0, "has no <Authentication>, so that Cyclone DDS does not start");
    diagnose_trusted_folder();
    if (!security_.access_control) report_no_access_control();
    for (const auto& expected : kExpected)
      if (const auto& plugin = security_.*expected.plugin) {
        diagnose_library(expected, with_variables(*plugin));
        diagnose_values(expected, *plugin);
      }
  }

 private:
  void report(Rule rule, int line, std::string_view what, std::string hint = {}) {
    out_.report(kCycloneFails, {.rule = rule,
                                .message = fmt::format("{} {}", question_.name, what),
                                .document = question_.document,
                                .line = line,
                                .hint = std::move(hint)});
  }
  void refuse(int line, std::string_view what) { report(Rule::DOC102, line, what); }

  void warn(const ConfiguredText& doubt) {
    out_.report({}, {.rule = Rule::DOC102,
                     .message = fmt::format("{} {}: Cyclone DDS 0.10 does not know that, and does "
                                            "not start with what it does not know",
                                            question_.name, doubt.text),
                     .document = question_.document,
                     .line = doubt.line,
                     .severity = Severity::warning});
  }

  void diagnose_absence() {
    if (security_.other_domain.empty())
      return report(Rule::DOC101, 0,
                    fmt::format("has no <Security> for domain {}: a Cyclone DDS process that "
                                "starts with it runs without security, and reads nothing of {}",
                                question_.domain, question_.folder.paths.folder.string()));
    report(Rule::DOC101, 0,
           fmt::format("has <Security> for domain {} only: in domain {}, which was judged, a "
                       "Cyclone DDS process that starts with it runs without security",
                       security_.other_domain, question_.domain),
           fmt::format("write <Domain Id=\"any\"> or <Domain Id=\"{}\">; --domain N judges another "
                       "domain",
                       question_.domain));
  }

  // Measured: Cyclone DDS's own plugins refuse the element with and without <CRL>, ddssec's only
  // with <CRL>.
  void diagnose_trusted_folder() {
    const auto* named = security_.authentication->value("trustedcadirectory");
    if (named == nullptr || named->text.empty()) return;
    const auto* list = security_.authentication->value("crl");
    if (list != nullptr && !list->text.empty())
      return refuse(named->line,
                    "names a <TrustedCADirectory> and a <CRL>, which do not go together, so that "
                    "Cyclone DDS does not start");
    report(Rule::DOC008, named->line,
           fmt::format("names the folder {} as <TrustedCADirectory>: Cyclone DDS's own plugins do "
                       "not start with it, and ddssec's believe peers by every CA in it, without "
                       "a revocation list; {} is what was judged",
                       named->text, question_.folder.paths.identity_ca.string()),
           "put all CAs into the identity_ca file, and leave the element out");
  }

  void report_no_access_control() {
    const auto& paths = question_.folder.paths;
    refuse(0, fmt::format("has no <AccessControl>: Cyclone DDS's own plugins start without {} and "
                          "{}, which were judged, and ddssec's do not start",
                          paths.governance.filename().string(),
                          paths.permissions.filename().string()));
  }

  void diagnose_library(const PluginRequirements& expected, const ConfiguredPlugin& plugin) {
    const auto* path = plugin.attribute("path");
    const bool is_name =
        path == nullptr || path->text == expected.stock || path->text == expected.ours;
    if (is_name) return diagnose_functions(expected, plugin);
    if (const auto* other = named_function_of_another(expected, plugin))
      return refuse(path->line,
                    fmt::format("names the library of <{}> in <{}>: Cyclone DDS does not start",
                                other->element, expected.element));
    auto places = LoaderPlaces::here();
    const auto file = library_file(path->text, places);
    if (file.empty()) return report_missing_library(expected, *path);
    if (path->text.ends_with(fmt::format("/lib{}.so", expected.stock)))
      return diagnose_functions(expected, plugin);
    for (const auto& [attribute, function] : {std::pair{"initfunction", expected.init},
                                              std::pair{"finalizefunction", expected.finalize}}) {
      const auto* named = plugin.attribute(attribute);
      diagnose_has_function(expected, *path, file, named != nullptr ? named->text : function);
    }
    places.library_path.clear();
    if (library_file(path->text, places).empty()) report_without_library_path(expected, *path);
  }

  // It is wrong only if a function has the name for another plugin, because other libraries have
  // their own names for functions.
  static const PluginRequirements* named_function_of_another(const PluginRequirements& expected,
                                                             const ConfiguredPlugin& plugin) {
    const auto* named = plugin.attribute("initfunction");
    const auto other = std::ranges::find_if(kExpected, [&](const PluginRequirements& one) {
      return one.element != expected.element && named != nullptr && named->text == one.init;
    });
    return other == std::end(kExpected) ? nullptr : &*other;
  }

  // The values as the application reads them if it has the environment of this process.
  ConfiguredPlugin with_variables(ConfiguredPlugin plugin) {
    for (auto* list : {&plugin.library, &plugin.values})
      for (auto& [name, value] : *list) {
        auto expanded = expanded_variables(value.text, question_.domain);
        if (!expanded)
          refuse(value.line, fmt::format("has the value \"{}\", whose variables Cyclone DDS cannot "
                                         "replace, or replaces in each process by another value",
                                         value.text));
        value.text = std::move(expanded).value_or("");
      }
    return plugin;
  }

  void diagnose_functions(const PluginRequirements& expected, const ConfiguredPlugin& plugin) {
    diagnose_function(expected, plugin.attribute("initfunction"), "initFunction", expected.init);
    diagnose_function(expected, plugin.attribute("finalizefunction"), "finalizeFunction",
                      expected.finalize);
  }

  // The name of an exported function is a text in the library file.
  void diagnose_has_function(const PluginRequirements& expected, const ConfiguredText& path,
                             const std::filesystem::path& file, std::string_view function) {
    const auto text = fmt::format("{0}{1}{0}", '\0', function);
    if (!library_octets(file).contains(text))
      refuse(path.line, fmt::format("names the library {} in <{}>, which has no function {}: "
                                    "Cyclone DDS does not start",
                                    path.text, expected.element, function));
  }

  // Cyclone DDS of Debian finds its own libraries in a private folder, but only by their usual
  // names.
  void report_without_library_path(const PluginRequirements& expected, const ConfiguredText& path) {
    out_.report(
        {.cyclonedds = Outcome::fail},
        {.rule = Rule::DOC102,
         .message = fmt::format("{} names the library \"{}\" in <{}>: Cyclone DDS finds its "
                                "own by the name \"{}\", and does not start where "
                                "LD_LIBRARY_PATH does not lead to another",
                                question_.name, path.text, expected.element, expected.stock),
         .document = question_.document,
         .line = path.line});
  }

  // Reports a missing path only once, because usually the folder of all three libraries is missing.
  void report_missing_library(const PluginRequirements& expected, const ConfiguredText& path) {
    if (!path.text.contains('/'))
      return refuse(path.line,
                    fmt::format("names the library \"{}\" in <{}>, which is not found; that of "
                                "Cyclone DDS and of ddssec's drop-in is \"{}\"",
                                path.text, expected.element, expected.stock));
    if (std::exchange(has_missing_path_, true)) return;
    const bool is_there = library_state(path.text) == LibraryState::refused;
    if (!is_there && question_.may_run_elsewhere) return warn_of_place(expected, path);
    constexpr std::string_view kRemedy =
        "copy ddssec's drop-in folder to that place; or name the folder where it is: ddssec "
        "identity issue NAME --ca CA -o DIR --dropin DROPIN, or by hand in each <Library "
        "path=...>";
    report(
        Rule::DOC102, path.line,
        fmt::format("names the library {} in <{}>, which is {} this machine: Cyclone DDS "
                    "does not start",
                    path.text, expected.element, is_there ? "no library of" : "not on"),
        is_there ? std::string(kRemedy) : fmt::format("{}; otherwise {}", kIfElsewhere, kRemedy));
  }

  void warn_of_place(const PluginRequirements& expected, const ConfiguredText& path) {
    out_.report({}, {.rule = Rule::DOC007,
                     .message = fmt::format(
                         "{} names the library {} in <{}>, which is not on this machine; {}",
                         question_.name, path.text, expected.element, kIfElsewhere),
                     .document = question_.document,
                     .line = path.line,
                     .hint = "run ddssec doctor where the participant runs"});
  }

  void diagnose_function(const PluginRequirements& expected, const ConfiguredText* named,
                         std::string_view attribute, std::string_view function) {
    if (named != nullptr && named->text != function)
      refuse(named->line,
             fmt::format("has {}=\"{}\" in <{}>, and the library's function is \"{}\": "
                         "Cyclone DDS does not start",
                         attribute, named->text, expected.element, function));
  }

  void diagnose_values(const PluginRequirements& expected, const ConfiguredPlugin& plugin) {
    for (const auto name : expected.values) {
      if (name.empty()) continue;
      const auto* value = plugin.value(ascii_lower(name));
      if (value == nullptr || value->text.empty())
        refuse(value == nullptr ? 0 : value->line,
               fmt::format("names no <{}>, so that Cyclone DDS does not start", name));
    }
  }

  const CheckedConfiguration& question_;
  const EffectiveSecurity& security_;
  Diagnosis& out_;
  bool has_missing_path_ = false;
};

}  // namespace

void diagnose_effective_security(const CheckedConfiguration& question, Diagnosis& out) {
  Checks(question, out).run();
}

}  // namespace ddssec::governance::doctor
