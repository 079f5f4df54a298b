// Whether the configurations in a participant's folder name the files beside them.
#include <optional>
#include <system_error>

#include <fmt/format.h>

#include "base/source.hpp"
#include "governance/doctor/checks.hpp"
#include "governance/doctor/cyclonedds_configuration.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostOctets = 1024 * 1024;

std::string without_escapes(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const bool is_ampersand = text.starts_with("&amp;"), is_less = text.starts_with("&lt;");
    out += is_less ? '<' : text.front();
    text.remove_prefix(is_ampersand ? 5 : is_less ? 4 : 1);
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

}  // namespace

void check_configurations(const LoadedFolder& folder, Diagnosis& out) {
  for (const auto* name : {"cyclonedds.xml", "fastdds.xml"}) {
    const auto file = folder.paths.folder / name;
    const auto octets = ddssec::load("file://" + file.string(), "", kMostOctets);
    if (!octets) continue;
    out.pass(Rule::DOC007);
    const auto other = other_folder(without_comments(as_text(*octets)), folder.paths);
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
