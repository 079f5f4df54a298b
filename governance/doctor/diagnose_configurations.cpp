// Checks whether the configurations in a participant's folder name the files beside them.
#include <algorithm>
#include <cstdlib>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/shell_word.hpp"
#include "base/text.hpp"
#include "base/uri_source.hpp"
#include "governance/doctor/checks.hpp"
#include "governance/doctor/configuration_checks.hpp"
#include "governance/doctor/cyclonedds_configuration.hpp"
#include "governance/doctor/expanded_variables.hpp"
#include "governance/doctor/named_files.hpp"
#include "pki/certificate_source.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

using Files = pki::ParticipantFolder;

constexpr std::size_t kMaxOctets = 1024 * 1024;

// Measured with Fast DDS 2.9.1: any value that begins with 1 switches the default file off.
constexpr const char* kSkipVariable = "SKIP_DEFAULT_XML_FILE";

// Takes the next absolute path out of the text; empty if there is none. A relative path is skipped,
// because it depends on where the application starts.
std::optional<fs::path> next_path(std::string_view& text) {
  constexpr std::string_view kScheme = "file:";
  for (;;) {
    const auto at = text.find(kScheme);
    if (at == text.npos) return std::nullopt;
    text.remove_prefix(at + kScheme.size());
    if (text.starts_with("//")) text.remove_prefix(2);
    const fs::path path(without_escapes(text.substr(0, text.find_first_of("<\r\n"))));
    if (path.is_absolute()) return path;
  }
}

// The other folder from which the text names a file, although this folder has a file of that name.
// A CA or a governance document may well be shared; certificate, key and permissions belong to one
// participant.
std::optional<fs::path> other_folder(std::string_view text, const pki::ParticipantFolder& paths) {
  while (const auto named = next_path(text)) {
    for (const auto* own : {&paths.certificate, &paths.key, &paths.permissions}) {
      std::error_code ignored;
      if (named->filename() != own->filename() || !fs::exists(*own, ignored)) continue;
      if (!fs::equivalent(*named, *own, ignored)) return named->parent_path();
    }
  }
  return std::nullopt;
}

Result<Bytes> octets_of(const fs::path& path) {
  return ddssec::load_uri("file://" + path.string(), "", pki::kMaxDocumentOctets);
}

// True if the value names the judged file. A relative path depends on where the application starts:
// here, or in the folder.
bool is_judged(const std::string& value, const fs::path& judged, const fs::path& folder) {
  constexpr std::string_view kFile = "file:", kData = "data:,";
  if (value.starts_with(kData)) {
    const auto octets = octets_of(judged);
    return octets && as_text(*octets) == std::string_view(value).substr(kData.size());
  }
  if (judged.extension() == ".p11") {
    const auto uri = pki::uri_of(judged);
    return uri && *uri == value;
  }
  auto name = std::string_view(value);
  if (name.starts_with(kFile)) name.remove_prefix(kFile.size());
  if (name.starts_with("//")) name.remove_prefix(2);
  const fs::path path(name);
  if (path.is_relative())
    return has_same_octets(folder / path, judged) || has_same_octets(path, judged);
  return has_same_octets(path, judged);
}

// Returns only the scheme of a value that is not a path, because the value may be a key. A path is
// cut: someone else may have written the file.
std::string shown_value(const std::string& value) {
  constexpr std::size_t kMaxShown = 256;
  const auto scheme = value.substr(0, value.find(':'));
  if (scheme == "data" || scheme == "pkcs11") return "a " + scheme + ": value";
  return value.size() <= kMaxShown ? value : value.substr(0, kMaxShown) + "...";
}

// A configuration and its owner.
struct Configuration {
  std::string name;  // its name in sentences
  fs::path document;
  Outcomes outcomes;  // the outcomes if it names another file
  std::vector<NamedFile> files;
  bool is_fastdds = false;
  bool may_run_elsewhere = false;  // see Settings
};

bool has_scheme(std::string_view value) {
  return value.starts_with("file:") || value.starts_with("data:,") || value.starts_with("pkcs11:");
}

// Measured with Fast DDS 2.9.1: it accepts neither "file:/a" nor "/a".
bool has_fastdds_scheme(std::string_view value) {
  return value.starts_with("file://") || value.starts_with("data:,") ||
         value.starts_with("pkcs11:");
}

bool is_path(const NamedFile& named) { return named.value.starts_with("file:"); }

fs::path path_of(const NamedFile& named) {
  auto name = std::string_view(named.value).substr(std::string_view("file:").size());
  if (name.starts_with("//")) name.remove_prefix(2);
  return name;
}

// True if it names files and none of them is in the folder. Then the folder is a copy or is to be
// copied, and the files at these paths on the participant's machine are not known here.
bool leads_elsewhere(const Configuration& configuration, const fs::path& folder) {
  const auto is_own = [&](const NamedFile& named) {
    const auto path = path_of(named);
    std::error_code ignored;
    return path.is_relative() || fs::equivalent(path.parent_path(), folder, ignored);
  };
  return std::ranges::any_of(configuration.files, is_path) &&
         std::ranges::none_of(configuration.files, [&](const NamedFile& named) {
           return is_path(named) && is_own(named);
         });
}

// True also for a file that exists and cannot be read.
bool is_missing(const NamedFile& named) {
  if (!is_path(named)) return false;
  const auto path = path_of(named);
  return path.is_absolute() &&
         !ddssec::load_uri("file://" + path.string(), "", pki::kMaxDocumentOctets);
}

std::string sentence(const Configuration& configuration, const NamedFile& named,
                     const fs::path& judged) {
  const auto& [role, value] = named;
  const auto product = configuration.is_fastdds ? "Fast DDS" : "Cyclone DDS";
  if (is_missing(named))
    return fmt::format(
        "{} names {} as {}, which {} cannot read, so that it does not start; {} is "
        "what was judged",
        configuration.name, shown_value(value), role->property, product, judged.string());
  return fmt::format(
      "{} names {} as {}: a process that starts with it reads that, and not {}, "
      "which was judged",
      configuration.name, shown_value(value), role->property, judged.string());
}

// Measured with Cyclone DDS 0.10.2: its own access control leaves quotes and backslashes out of the
// path of the permissions, or replaces them.
void diagnose_odd_path(const Configuration& configuration, Diagnosis& out) {
  for (const auto& named : configuration.files) {
    const bool counts = named.role->judged == &Files::permissions && is_path(named);
    if (!counts || named.value.find_first_of("\"\\") == named.value.npos) continue;
    out.report(
        {.cyclonedds = Outcome::fail},
        {.rule = Rule::DOC008,
         .message = fmt::format("{} names {} as permissions: Cyclone DDS's own plugins do not "
                                "read a path with '\"' or '\\' as it stands, but another one",
                                configuration.name, shown_value(named.value)),
         .document = configuration.document,
         .hint = "rename the folder"});
  }
}

// The values to judge. Values that may be right on another machine are left out and get one warning
// together.
std::vector<NamedFile> named_here(const pki::ParticipantFolder& paths,
                                  const Configuration& configuration, Diagnosis& out) {
  auto files = configuration.files;
  if (!configuration.may_run_elsewhere || !leads_elsewhere(configuration, paths.folder))
    return files;
  const auto is_misplaced = [&](const NamedFile& named) {
    return is_path(named) && !is_judged(named.value, paths.*(named.role->judged), paths.folder);
  };
  const auto first = std::ranges::find_if(files, is_misplaced);
  if (first == files.end()) return files;
  out.report({}, {.rule = Rule::DOC007,
                  .message = fmt::format(
                      "{} names {}, which is not {}: the files in {} were judged; {}",
                      configuration.name, path_of(*first).string(),
                      is_missing(*first) ? "on this machine" : "the file of this folder",
                      paths.folder.string(), kIfElsewhere),
                  .document = configuration.document,
                  .hint = "run ddssec doctor where the participant runs"});
  std::erase_if(files, is_misplaced);
  return files;
}

std::string hint_for(const pki::ParticipantFolder& paths, const Configuration& configuration) {
  if (!leads_elsewhere(configuration, paths.folder)) return {};
  return fmt::format("{}; otherwise {}", kIfElsewhere, info(Rule::DOC008).hint);
}

void diagnose_judged(const LoadedFolder& folder, const Configuration& configuration,
                     Diagnosis& out) {
  const auto& paths = folder.paths;
  out.pass(Rule::DOC008);
  const auto report = [&](std::string message) {
    out.report(configuration.outcomes, {.rule = Rule::DOC008,
                                        .message = std::move(message),
                                        .document = configuration.document,
                                        .hint = hint_for(paths, configuration)});
  };
  for (const auto& named : named_here(paths, configuration, out)) {
    const auto& judged = paths.*(named.role->judged);
    if (!is_judged(named.value, judged, paths.folder))
      report(sentence(configuration, named, judged));
    else if (configuration.is_fastdds && !has_fastdds_scheme(named.value))
      report(fmt::format(
          "{} names {} as {}, and Fast DDS does not start without \"file://\" before "
          "the path; write file://{}",
          configuration.name, shown_value(named.value), named.role->property, judged.string()));
    else if (!configuration.is_fastdds && !has_scheme(named.value))
      report(
          fmt::format("{} names {} as {}, without \"file:\" before the path: Cyclone DDS does "
                      "not start; write file:{}",
                      configuration.name, shown_value(named.value), named.role->property,
                      shown_value(named.value)));
  }
  if (!configuration.is_fastdds) diagnose_odd_path(configuration, out);
  const auto is_crl = [](const NamedFile& named) { return named.role->judged == &Files::crl; };
  if (!configuration.files.empty() && folder.has_crl_file &&
      std::ranges::none_of(configuration.files, is_crl))
    report(fmt::format("{} names no revocation list, and {} was judged", configuration.name,
                       paths.crl.string()));
}

// True if the configuration names the participant's certificate or key. Otherwise the environment
// may be that of another participant.
bool is_of(const std::vector<NamedFile>& files, const pki::ParticipantFolder& paths) {
  return std::ranges::any_of(files, [&](const NamedFile& named) {
    const bool is_own =
        named.role->judged == &Files::certificate || named.role->judged == &Files::key;
    return is_own && is_judged(named.value, paths.*(named.role->judged), paths.folder);
  });
}

bool is_of(const CheckedProfile& question, const pki::ParticipantFolder& paths) {
  return is_of(named_by_fastdds(question.text), paths) ||
         is_of(named_anywhere_by_fastdds(without_comments(question.text)), paths);
}

constexpr Outcomes kCycloneFails{.cyclonedds = Outcome::fail, .ddssec = Outcome::fail};
constexpr Outcomes kFastFails{.fastdds = Outcome::fail};

void report_unreadable(std::string_view name, const fs::path& file, const Error& error,
                       Diagnosis& out) {
  out.report(name == "fastdds.xml" ? kFastFails : kCycloneFails,
             {.rule = Rule::DOC102,
              .message = fmt::format("{} cannot be read: {}", name, error.message()),
              .document = file});
}

void diagnose_other_folder(const LoadedFolder& folder, const char* name, std::string_view text,
                           Diagnosis& out) {
  out.pass(Rule::DOC007);
  const auto other = other_folder(text, folder.paths);
  if (!other) return;
  std::error_code ignored;
  const auto own = fs::absolute(folder.paths.folder, ignored).lexically_normal();
  out.report({}, {.rule = Rule::DOC007,
                  .message = fmt::format("{} names files in {}, and the participant's are in {}",
                                         name, other->string(), own.string()),
                  .document = folder.paths.folder / name});
}

// An application may secure itself by its QoS, as ROS 2 does. One that is to start with the
// folder's own configuration does not.
void warn_of_unsecured_environment(const CheckedConfiguration& question, Diagnosis& out) {
  const auto& paths = question.folder.paths;
  std::error_code ignored;
  const auto own = paths.folder / "cyclonedds.xml";
  if (paths.layout == pki::FolderLayout::sros2 || !fs::exists(own, ignored)) return;
  out.report({}, {.rule = Rule::DOC101,
                  .message = fmt::format(
                      "{} has no <Security> for domain {}, and {} has: an application that starts "
                      "in this environment runs without security, unless its QoS names the files",
                      question.name, question.domain, own.string()),
                  .document = question.document,
                  .hint = "export CYCLONEDDS_URI=" +
                          shell_word("file://" + fs::absolute(own, ignored).string()),
                  .severity = Severity::warning});
}

// True if all values that every participant needs are there.
bool is_complete(const EffectiveSecurity& security) {
  const auto has = [](const std::optional<ConfiguredPlugin>& plugin, std::string_view element) {
    const auto* const value = plugin ? plugin->value(element) : nullptr;
    return value != nullptr && !value->text.empty();
  };
  return std::ranges::all_of(kRoles, [&](const Role& role) {
    return role.element == "crl" || has(security.authentication, role.element) ||
           has(security.access_control, role.element);
  });
}

void diagnose_cyclonedds(const LoadedFolder& folder, const Settings& settings, const fs::path& file,
                         std::string_view text, Diagnosis& out) {
  const auto name = name_of(file);
  const auto security = effective_security(text, settings.domain, ConfigurationPlace::file);
  diagnose_judged(folder,
                  {.name = name,
                   .document = file,
                   .outcomes = kCycloneFails,
                   .files = named_by_cyclonedds(without_comments(text), security, settings.domain),
                   .may_run_elsewhere = settings.may_run_elsewhere},
                  out);
  diagnose_effective_security(
      {name, file, folder, settings.domain, security, settings.may_run_elsewhere}, out);
}

void diagnose_fastdds(const LoadedFolder& folder, const CheckedProfile& question, Diagnosis& out,
                      bool may_run_elsewhere = false) {
  diagnose_judged(folder,
                  {.name = question.name,
                   .document = question.document,
                   .outcomes = kFastFails,
                   .files = named_by_fastdds(question.text),
                   .is_fastdds = true,
                   .may_run_elsewhere = may_run_elsewhere},
                  out);
  diagnose_profile(question, out);
}

}  // namespace

void diagnose_profile_in_force(const LoadedFolder& folder, const fs::path& file,
                               const Settings& settings, Diagnosis& out) {
  std::error_code ignored;
  const auto version = settings.lineup.fastdds;
  const auto variable = profile_places(version).variable;
  const auto octets =
      ddssec::load_uri("file://" + fs::absolute(file, ignored).string(), "", kMaxOctets);
  const auto own = folder.paths.folder / "fastdds.xml";
  if (octets && fs::equivalent(file, own, ignored))
    return;  // diagnose_configurations has checked it
  if (octets) {
    const CheckedProfile question{fmt::format("the file that {} names", variable), file,
                                  as_text(*octets), version};
    if (is_of(question, folder.paths)) return diagnose_fastdds(folder, question, out);
  }
  if (folder.paths.layout == pki::FolderLayout::sros2 || !fs::exists(own, ignored)) return;
  out.report({},
             {.rule = Rule::DOC101,
              .message = fmt::format(
                  "{} names {}, which {}: a Fast DDS application that starts in this "
                  "environment does not read {}",
                  variable, file.string(),
                  octets ? "names no file of this participant" : "cannot be read", own.string()),
              .document = file,
              .hint = fmt::format("export {}={}", variable,
                                  shell_word(fs::absolute(own, ignored).string())),
              .severity = Severity::warning});
}

void diagnose_profile_of_working_directory(const LoadedFolder& folder, const Settings& settings,
                                           Diagnosis& out) {
  const char* const skip = std::getenv(kSkipVariable);
  const auto version = settings.lineup.fastdds;
  const fs::path file(profile_places(version).file);
  const auto own = folder.paths.folder / "fastdds.xml";
  std::error_code ignored;
  const bool is_skipped = skip != nullptr && *skip == '1';
  if (is_skipped || !fs::exists(file, ignored) || fs::equivalent(file, own, ignored)) return;
  const auto octets =
      ddssec::load_uri("file://" + fs::absolute(file, ignored).string(), "", kMaxOctets);
  if (octets && !may_set_default_participant(as_text(*octets))) return;
  const CheckedProfile question{fmt::format("{} in the working directory", file.string()), file,
                                octets ? as_text(*octets) : std::string_view(), version};
  if (is_of(question, folder.paths)) return diagnose_fastdds(folder, question, out);
  if (folder.paths.layout == pki::FolderLayout::sros2 || !fs::exists(own, ignored)) return;
  out.report(
      kFastFails,
      {.rule = Rule::DOC101,
       .message = fmt::format("{}: a Fast DDS application that starts here takes its default "
                              "profile from it, whatever {} names, and runs without the "
                              "security of {}",
                              question.name, profile_places(version).variable, own.string()),
       .document = fs::absolute(file, ignored),
       .hint = fmt::format(
           "move the file to another folder; or export {}=1 where the application starts",
           kSkipVariable)});
}

void diagnose_configuration_in_force(const LoadedFolder& folder,
                                     const ConfigurationInForce& in_force, const Settings& settings,
                                     Diagnosis& out) {
  const auto text = in_force.text;
  const auto security =
      effective_security(text, settings.domain, ConfigurationPlace::variable, in_force.inline_from);
  const Configuration configuration{
      "the configuration that CYCLONEDDS_URI names", "CYCLONEDDS_URI", kCycloneFails,
      named_by_cyclonedds(without_comments(text), security, settings.domain)};
  const CheckedConfiguration question{configuration.name, configuration.document, folder,
                                      settings.domain, security};
  if (is_of(configuration.files, folder.paths)) {
    diagnose_judged(folder, configuration, out);
    return diagnose_effective_security(question, out);
  }
  // With a configuration that is broken or incomplete no participant starts.
  if (!security.problems.empty() || (security.applies && !is_complete(security)))
    return diagnose_effective_security(question, out);
  if (!security.applies) warn_of_unsecured_environment(question, out);
}

void diagnose_configurations(const LoadedFolder& folder, const Settings& settings, Diagnosis& out) {
  for (const auto* name : {"cyclonedds.xml", "fastdds.xml"}) {
    const auto file = folder.paths.folder / name;
    const bool is_cyclonedds = name == std::string_view("cyclonedds.xml");
    const auto uri = "file://" + file.string();
    const auto octets =
        is_cyclonedds ? load_or_empty(uri, "", kMaxOctets) : ddssec::load_uri(uri, "", kMaxOctets);
    std::error_code ignored;
    if (!octets && fs::exists(file, ignored)) report_unreadable(name, file, octets.error(), out);
    if (!octets) continue;
    const auto text = as_text(*octets);
    if (is_cyclonedds)
      diagnose_cyclonedds(folder, settings, file, text, out);
    else
      diagnose_fastdds(folder, {name, file, text, settings.lineup.fastdds}, out,
                       settings.may_run_elsewhere);
    if (settings.may_run_elsewhere) continue;
    const auto read = without_comments(text);
    const auto expanded = is_cyclonedds ? expanded_variables(read, settings.domain) : std::nullopt;
    diagnose_other_folder(folder, name, expanded.value_or(read), out);
  }
}

}  // namespace ddssec::governance::doctor
