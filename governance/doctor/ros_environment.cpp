#include "governance/doctor/ros_environment.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "governance/decision.hpp"
#include "governance/doctor/checks.hpp"
#include "governance/doctor/domains_of_folder.hpp"
#include "governance/doctor/host_plugins.hpp"
#include "governance/doctor/library_search.hpp"
#include "governance/doctor/loader_subfolders.hpp"
#include "governance/ros_node.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

constexpr Outcomes kAll = Outcomes::all(Outcome::fail);

std::string value(const RosEnvironment& environment, std::string_view name) {
  const auto found = environment.find(name);
  return found == environment.end() ? "" : found->second;
}

// These two variables count only if they are spelt exactly so.
void diagnose_word(const RosEnvironment& environment, std::string_view name,
                   std::string_view wanted, Rule rule, Diagnosis& out) {
  const auto found = value(environment, name);
  if (found == wanted) return out.pass(rule);
  out.report(kAll, {.rule = rule,
                    .message = found.empty()
                                   ? fmt::format("{} is not set; it must be \"{}\"", name, wanted)
                                   : fmt::format("{} is \"{}\"; it must be exactly \"{}\"", name,
                                                 found, wanted)});
}

fs::path resolved(const fs::path& path) {
  std::error_code error;
  auto out = fs::weakly_canonical(path, error);
  return error ? path : out;
}

void diagnose_enclave(const LoadedFolder& folder, const RosEnvironment& environment,
                      Diagnosis& out) {
  const auto keystore = value(environment, "ROS_SECURITY_KEYSTORE");
  const auto name = value(environment, "ROS_SECURITY_ENCLAVE_OVERRIDE");
  const auto report = [&](std::string message) {
    out.report(
        kAll,
        {.rule = Rule::DOC062, .message = std::move(message), .document = folder.paths.folder});
  };
  if (keystore.empty()) return report("ROS_SECURITY_KEYSTORE is not set");
  const auto enclaves = resolved(fs::path(keystore) / "enclaves");
  const auto here = resolved(folder.paths.folder);
  const auto inside = here.lexically_relative(enclaves);
  if (inside.empty() || *inside.begin() == "..")
    return report(fmt::format("ROS_SECURITY_KEYSTORE is \"{}\", and {} is not below its enclaves/",
                              keystore, here.string()));
  if (!name.empty() && !name.starts_with('/'))
    return report(
        fmt::format("ROS_SECURITY_ENCLAVE_OVERRIDE is \"{}\", and the name of an enclave "
                    "begins with \"/\": the node ends at start, because it leaves out the "
                    "first character",
                    name));
  if (!name.empty() && resolved(enclaves / fs::path(name).relative_path()) != here)
    return report(
        fmt::format("ROS_SECURITY_ENCLAVE_OVERRIDE is \"{}\"; this is the enclave \"/{}\"", name,
                    inside.string()));
  out.pass(Rule::DOC062);
  if (fs::path(keystore).is_relative())
    out.report({}, {.rule = Rule::DOC062,
                    .message = fmt::format("ROS_SECURITY_KEYSTORE is \"{}\": a node that starts in "
                                           "another folder does not find the enclave",
                                           keystore),
                    .document = folder.paths.folder,
                    .hint = "set ROS_SECURITY_KEYSTORE to the whole path of the keystore",
                    .severity = Severity::warning});
}

// A node runs in the domain of its environment, whatever the documents say.
void diagnose_domain(const LoadedFolder& folder, const RosEnvironment& environment,
                     const Settings& settings, Diagnosis& out) {
  const auto found = value(environment, "ROS_DOMAIN_ID");
  const auto domain = node_domain(found).value_or(0);
  const Domains named = domains_of(folder, settings.now);
  const bool fits = named.empty() || contains(named, domain);
  if (fits) return out.pass(Rule::DOC096);
  out.report(kAll,
             {.rule = Rule::DOC096,
              .message = fmt::format("{}, so a node runs in domain {}; the documents are for {}",
                                     found.empty() ? "ROS_DOMAIN_ID is not set"
                                                   : fmt::format("ROS_DOMAIN_ID is \"{}\"", found),
                                     domain, to_text(named)),
              .hint = fmt::format("export ROS_DOMAIN_ID={} wherever the node starts",
                                  named.front().first)});
}

void diagnose_names(const LoadedFolder& folder, const RosEnvironment& environment, Diagnosis& out) {
  out.pass(Rule::DOC063);
  if (folder.paths.layout != pki::FolderLayout::sros2)
    out.report(kAll, {.rule = Rule::DOC063,
                      .message = fmt::format("{} is called so; ROS reads identity_ca.cert.pem and "
                                             "permissions_ca.cert.pem",
                                             folder.paths.identity_ca.filename().string()),
                      .document = folder.paths.identity_ca});
  if (value(environment, "RMW_IMPLEMENTATION") != "rmw_cyclonedds_cpp") return;
  std::error_code ignored;
  for (const auto* file :
       {"identity_ca.cert.p11", "cert.p11", "key.p11", "permissions_ca.cert.p11"})
    if (fs::exists(folder.paths.folder / file, ignored))
      out.report({.cyclonedds = Outcome::fail, .ddssec = Outcome::fail},
                 {.rule = Rule::DOC063,
                  .message = fmt::format("{} names a key store in hardware, and "
                                         "RMW_IMPLEMENTATION is \"rmw_cyclonedds_cpp\", which does "
                                         "not read such files",
                                         file),
                  .document = folder.paths.folder / file});
}

// The plugin libraries that rmw_cyclonedds_cpp loads.
constexpr std::array<const char*, 3> kPluginFiles{
    "libdds_security_auth.so", "libdds_security_ac.so", "libdds_security_crypto.so"};

std::string reason_without_ours(std::string_view path, const char* library,
                                const FoundLibrary& found) {
  const auto file = found.file.string();
  switch (found.state) {
    case LibraryState::absent:
      return fmt::format("no folder of LD_LIBRARY_PATH (\"{}\") holds {}", path, library);
    case LibraryState::refused:
      return file + " is no library of this machine, and the loader looks no further";
    case LibraryState::cut_off:
      return file + " is cut off: the process that loads it ends with a bus error";
    case LibraryState::loadable:
      break;
  }
  return file + " comes first on LD_LIBRARY_PATH and is not of ddssec";
}

// Without ddssec's plugins a node still runs, with those that are installed.
void diagnose_plugins_of_node(const RosEnvironment& environment, Diagnosis& out) {
  const auto rmw = value(environment, "RMW_IMPLEMENTATION");
  if (rmw != "rmw_cyclonedds_cpp")
    return out.report(
        {.cyclonedds = Outcome::fail, .ddssec = Outcome::fail},
        {.rule = Rule::DOC067,
         .message = rmw.empty()
                        ? "RMW_IMPLEMENTATION is not set: a node runs on the installation's "
                          "default, as a rule Fast DDS with its own plugins"
                        : fmt::format("RMW_IMPLEMENTATION is \"{}\": a node does not run on "
                                      "Cyclone DDS, and not on ddssec's plugins",
                                      rmw)});
  out.pass(Rule::DOC067);
  const auto path = value(environment, "LD_LIBRARY_PATH");
  out.pass(Rule::DOC068);
  for (const auto* library : kPluginFiles) {
    const auto found = found_in(folders_of(path), loader_subfolders(), library);
    const bool is_found = found.state == LibraryState::loadable && is_ours(found.file);
    if (is_found && found.file.is_absolute()) continue;
    if (is_found)
      return out.report({},
                        {.rule = Rule::DOC068,
                         .message = fmt::format("LD_LIBRARY_PATH (\"{}\") names the folder of {} "
                                                "from here: a node that starts in another "
                                                "folder runs on the stock plugins",
                                                path, found.file.string()),
                         .document = found.file,
                         .hint = "name it by its whole path, which begins with /",
                         .severity = Severity::warning});
    return out.report({.ddssec = Outcome::fail},
                      {.rule = Rule::DOC068,
                       .message = reason_without_ours(path, library, found) +
                                  ": a node runs on the stock plugins, or does not start",
                       .document = found.file});
  }
}

void diagnose_discovery_topic(const LoadedFolder& folder, const CompiledGrant& grant,
                              Diagnosis& out) {
  out.pass(Rule::DOC064);
  for (const auto action : {Action::publish, Action::subscribe}) {
    const auto decision = grant.judge(action, {.topic = "ros_discovery_info"});
    if (!decision.allowed)
      out.report(Outcomes::all(Outcome::late),
                 {.rule = Rule::DOC064,
                  .message = fmt::format("grant \"{}\" does not allow to {} ros_discovery_info",
                                         grant.grant().name,
                                         action == Action::publish ? "publish" : "subscribe to"),
                  .document = folder.paths.permissions,
                  .line = decision.line(grant.grant())});
  }
}

bool is_ros_name(std::string_view name) {
  constexpr std::array<std::string_view, 3> kPrefixes{"rt/", "rq/", "rr/"};
  const bool has_prefix =
      std::ranges::any_of(kPrefixes, [&](auto prefix) { return name.starts_with(prefix); });
  return has_prefix || name == "ros_discovery_info" ||
         name.find_first_of("*?[") < std::string_view("rt/").size();
}

template <class Each>
void each_topic(const Grant& grant, Each&& each) {
  for (const auto& rule : grant.rules)
    for (const auto* list : {&rule.publish, &rule.subscribe})
      for (const auto& criteria : *list)
        for (const auto& topic : criteria.topics) each(topic, list == &rule.publish);
}

void diagnose_topic_names(const LoadedFolder& folder, const Grant& grant, Diagnosis& out) {
  out.pass(Rule::DOC065);
  each_topic(grant, [&](const Text& topic, bool) {
    if (is_ros_name(topic.text)) return;
    out.report({},
               {.rule = Rule::DOC065,
                .message = fmt::format("\"{}\" is no name that ROS gives to a topic; a ROS topic "
                                       "of that name is \"rt/{}\"",
                                       topic.text, topic.text.substr(topic.text.starts_with('/'))),
                .document = folder.paths.permissions,
                .line = topic.line});
  });
}

// Measured with nodes of ROS 2 Humble: an rclcpp node aborts if any of these rights is missing.
void diagnose_node_rights(const LoadedFolder& folder, const Grant& grant, DomainId domain,
                          Diagnosis& out) {
  out.pass(Rule::PERM040);
  const auto missing = missing_node_rights(grant, domain);
  if (missing.empty()) return;
  out.report(
      Outcomes::all(Outcome::late),
      {.rule = Rule::PERM040,
       .message = fmt::format("an rclcpp node does not start in domain {}: grant \"{}\" does "
                              "not allow it to {}",
                              domain, grant.name, fmt::join(missing, ", ")),
       .document = folder.paths.permissions,
       .line = grant.line,
       .hint = "add it from the policy: ddssec keystore permission KEYSTORE ENCLAVE --policy "
               "FILE --node-defaults; without a policy, allow these topics in the "
               "permissions document",
       .severity = Severity::error});
}

void diagnose_rosout(const LoadedFolder& folder, const CompiledGrant& grant, Diagnosis& out) {
  out.pass(Rule::DOC066);
  if (grant.judge(Action::publish, {.topic = "rt/rosout"}).allowed) return;
  each_topic(grant.grant(), [&](const Text& topic, bool publish) {
    if (!publish || !topic.text.ends_with("/rosout")) return;
    out.report({}, {.rule = Rule::DOC066,
                    .message = fmt::format("the grant allows publishing \"{}\", and ROS publishes "
                                           "\"rt/rosout\"",
                                           topic.text),
                    .document = folder.paths.permissions,
                    .line = topic.line});
  });
}

}  // namespace

RosEnvironment ros_environment() {
  RosEnvironment out;
  for (const auto* name :
       {"ROS_SECURITY_ENABLE", "ROS_SECURITY_STRATEGY", "ROS_SECURITY_KEYSTORE",
        "ROS_SECURITY_ENCLAVE_OVERRIDE", "ROS_DOMAIN_ID", "RMW_IMPLEMENTATION", "LD_LIBRARY_PATH"})
    if (const char* set = std::getenv(name)) out.emplace(name, set);
  return out;
}

// Measured with rcl of ROS 2 Humble: 010 is domain 8; " 7", "+7" and "7 rest" are domain 7; a node
// with 08 ends.
std::optional<DomainId> node_domain(const std::string& ros_domain_id) {
  if (ros_domain_id.empty()) return 0;
  if (ros_domain_id.contains('-')) return std::nullopt;
  char* end = nullptr;
  const auto number = std::strtoul(ros_domain_id.c_str(), &end, 0);
  const bool is_none = number == 0 && *end != '\0';
  if (is_none || number > static_cast<unsigned long>(kMaxGovernedDomainId)) return std::nullopt;
  return static_cast<DomainId>(number);
}

void diagnose_ros(const LoadedFolder& folder, const RosEnvironment& environment,
                  const Settings& settings, Diagnosis& out) {
  diagnose_word(environment, "ROS_SECURITY_ENABLE", "true", Rule::DOC060, out);
  diagnose_word(environment, "ROS_SECURITY_STRATEGY", "Enforce", Rule::DOC061, out);
  diagnose_enclave(folder, environment, out);
  diagnose_domain(folder, environment, settings, out);
  diagnose_plugins_of_node(environment, out);
  diagnose_names(folder, environment, out);
  const auto* grant = grant_of(folder, settings.now);
  if (grant == nullptr) return;
  const CompiledGrant compiled(folder.permissions.model, *grant, settings.domain);
  diagnose_discovery_topic(folder, compiled, out);
  diagnose_topic_names(folder, *grant, out);
  diagnose_rosout(folder, compiled, out);
  diagnose_node_rights(folder, *grant, settings.domain, out);
}

namespace {

// A warning, because an application that uses no ROS may use the enclave.
void diagnose_no_ros_topic(const LoadedFolder& folder, const Grant& grant, DomainId domain,
                           Diagnosis& out) {
  if (missing_node_rights(grant, domain).empty()) return;
  out.report({}, {.rule = Rule::PERM034,
                  .message = fmt::format("grant \"{}\" names no topic of ROS 2, so no ROS 2 node "
                                         "starts in this enclave",
                                         grant.name),
                  .document = folder.paths.permissions,
                  .line = grant.line,
                  .hint = "nothing needs to be done if no ROS 2 node uses the enclave; otherwise "
                          "ddssec keystore permission KEYSTORE ENCLAVE --policy FILE "
                          "--node-defaults",
                  .severity = Severity::warning});
}

}  // namespace

void diagnose_ros_rights(const LoadedFolder& folder, const Settings& settings, Diagnosis& out) {
  const auto* grant = grant_of(folder, settings.now);
  if (grant == nullptr) return;
  if (!speaks_of_ros(*grant)) return diagnose_no_ros_topic(folder, *grant, settings.domain, out);
  diagnose_discovery_topic(folder, {folder.permissions.model, *grant, settings.domain}, out);
  diagnose_node_rights(folder, *grant, settings.domain, out);
}

}  // namespace ddssec::governance::doctor
