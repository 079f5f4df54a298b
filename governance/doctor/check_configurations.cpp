// Whether the configurations in a participant's folder name the files beside them.
#include <algorithm>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/source.hpp"
#include "base/text.hpp"
#include "governance/doctor/checks.hpp"
#include "governance/doctor/cyclonedds_configuration.hpp"
#include "pki/source.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostOctets = 1024 * 1024;

std::string without_escapes(std::string_view text) {
  constexpr std::pair<std::string_view, char> kEscapes[] = {
      {"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}};
  std::string out;
  while (!text.empty()) {
    const auto* const escape = std::ranges::find_if(
        kEscapes, [&](const auto& one) { return text.starts_with(one.first); });
    const bool is_escape = escape != std::end(kEscapes);
    out += is_escape ? escape->second : text.front();
    text.remove_prefix(is_escape ? escape->first.size() : 1);
  }
  return out;
}

// Nothing for a relative path: where that leads depends on where the application starts.
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

// The other folder of which the text names a file that this one has. A CA or a governance document
// may well be shared; certificate, key and permissions belong to one participant.
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

/// A file of a participant, as configurations call it.
struct Role {
  std::string_view element;   ///< of Cyclone DDS's configuration, lower case
  std::string_view property;  ///< the last part of Fast DDS's property
  fs::path pki::ParticipantFolder::*judged;
};
using Files = pki::ParticipantFolder;
constexpr Role kRoles[] = {
    {"identityca", "identity_ca", &Files::identity_ca},
    {"identitycertificate", "identity_certificate", &Files::certificate},
    {"privatekey", "private_key", &Files::key},
    {"crl", "identity_crl", &Files::crl},
    {"permissionsca", "permissions_ca", &Files::permissions_ca},
    {"governance", "governance", &Files::governance},
    {"permissions", "permissions", &Files::permissions},
};

/// What a configuration says of a role.
struct Named {
  const Role* role;
  std::string value;  ///< "file:/a/b", "data:,..." or "pkcs11:..."
};

std::string content_of(std::string_view after_tag) {
  return without_escapes(trimmed(after_tag.substr(0, after_tag.find("</")), " \t\r\n"));
}

std::vector<Named> named_by_cyclonedds(std::string_view text) {
  std::vector<Named> out;
  for (const auto& role : kRoles)
    for (auto tag = find_tag(text, role.element); tag; tag = find_tag(tag->after, role.element))
      out.push_back({&role, content_of(tag->after)});
  return out;
}

std::vector<Named> named_by_fastdds(std::string_view text) {
  std::vector<Named> out;
  for (auto tag = find_tag(text, "name"); tag; tag = find_tag(tag->after, "name")) {
    const auto name = content_of(tag->after);
    const auto value = find_tag(tag->after, "value");
    if (!name.starts_with("dds.sec.") || !value) continue;
    const auto* const role = std::ranges::find(
        kRoles, std::string_view(name).substr(name.rfind('.') + 1), &Role::property);
    if (role != std::end(kRoles)) out.push_back({role, content_of(value->after)});
  }
  return out;
}

Result<Bytes> octets_of(const fs::path& path) {
  return ddssec::load("file://" + path.string(), "", pki::kMostDocumentOctets);
}

// Where a relative path leads depends on where the application starts: here, or in the folder. What
// is missing keeps the process from starting.
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
  std::error_code ignored;
  const bool is_missing = fs::status(path, ignored).type() == fs::file_type::not_found;
  return (is_missing && name.find('$') == name.npos) || has_same_octets(path, judged);
}

// Of a value that is no path only its beginning: it may be a key.
std::string shown_value(const std::string& value) {
  const auto scheme = value.substr(0, value.find(':'));
  return scheme == "data" || scheme == "pkcs11" ? "a " + scheme + ": value" : value;
}

/// A configuration and whose it is.
struct Configuration {
  std::string name;  ///< what sentences call it
  fs::path document;
  Outcomes outcomes;  ///< where it names another file
  std::vector<Named> files;
};

void check_judged(const LoadedFolder& folder, const Configuration& configuration, Diagnosis& out) {
  const auto& paths = folder.paths;
  out.pass(Rule::DOC008);
  const auto report = [&](std::string message) {
    out.report(
        configuration.outcomes,
        {.rule = Rule::DOC008, .message = std::move(message), .document = configuration.document});
  };
  for (const auto& [role, value] : configuration.files) {
    const auto& judged = paths.*(role->judged);
    if (!is_judged(value, judged, paths.folder))
      report(fmt::format("{} makes the process read {} as {}, and {} is what was judged",
                         configuration.name, shown_value(value), role->property, judged.string()));
  }
  const auto is_crl = [](const Named& named) { return named.role->judged == &Files::crl; };
  if (!configuration.files.empty() && folder.has_crl_file &&
      std::ranges::none_of(configuration.files, is_crl))
    report(fmt::format("{} names no revocation list, and {} was judged", configuration.name,
                       paths.crl.string()));
}

// The environment may be that of another participant.
bool is_of(const Configuration& configuration, const pki::ParticipantFolder& paths) {
  return std::ranges::any_of(configuration.files, [&](const Named& named) {
    const bool is_own =
        named.role->judged == &Files::certificate || named.role->judged == &Files::key;
    return is_own && is_judged(named.value, paths.*(named.role->judged), paths.folder);
  });
}

constexpr Outcomes kCycloneFails{.cyclonedds = Outcome::fail, .ours = Outcome::fail};
constexpr Outcomes kFastFails{.fastdds = Outcome::fail};

}  // namespace

void check_configuration_in_force(const LoadedFolder& folder, std::string_view text,
                                  Diagnosis& out) {
  const Configuration configuration{"the configuration that CYCLONEDDS_URI names", "CYCLONEDDS_URI",
                                    kCycloneFails, named_by_cyclonedds(without_comments(text))};
  if (is_of(configuration, folder.paths)) check_judged(folder, configuration, out);
}

void check_configurations(const LoadedFolder& folder, Diagnosis& out) {
  for (const auto* name : {"cyclonedds.xml", "fastdds.xml"}) {
    const auto file = folder.paths.folder / name;
    const auto octets = ddssec::load("file://" + file.string(), "", kMostOctets);
    if (!octets) continue;
    out.pass(Rule::DOC007);
    const auto text = without_comments(as_text(*octets));
    const bool is_cyclonedds = name == std::string_view("cyclonedds.xml");
    check_judged(folder,
                 {name, file, is_cyclonedds ? kCycloneFails : kFastFails,
                  is_cyclonedds ? named_by_cyclonedds(text) : named_by_fastdds(text)},
                 out);
    const auto other = other_folder(text, folder.paths);
    if (!other) continue;
    std::error_code ignored;
    const auto own = fs::absolute(folder.paths.folder, ignored).lexically_normal();
    out.report({}, {.rule = Rule::DOC007,
                    .message = fmt::format("{} names files in {}, and the participant's are in {}",
                                           name, other->string(), own.string()),
                    .document = file});
  }
}

}  // namespace ddssec::governance::doctor
