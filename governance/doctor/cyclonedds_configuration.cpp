#include "governance/doctor/cyclonedds_configuration.hpp"

#include <algorithm>
#include <cstdlib>
#include <system_error>

#include "base/text.hpp"
#include "base/uri_source.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxOctets = 1024 * 1024;
constexpr std::string_view kVariable = "CYCLONEDDS_URI";
constexpr std::string_view kBlanks = " \t\r\n";
constexpr std::string_view kAfterName = " \t\r\n/>";
constexpr std::string_view kScheme = "file://";

// Takes the next file's name. XML goes to the end of the variable, because it may contain commas.
std::optional<std::string_view> next_name(std::string_view& uri) {
  while (!uri.empty() && (uri.front() == ',' || kBlanks.contains(uri.front())))
    uri.remove_prefix(1);
  if (uri.empty()) return std::nullopt;
  const auto name = uri.front() == '<' ? uri : uri.substr(0, uri.find(','));
  uri.remove_prefix(name.size());
  return name;
}

// Cyclone DDS only removes "file://". It takes "file:NAME" for the name of a file.
fs::path path_of(std::string_view name) {
  return fs::path(name.starts_with(kScheme) ? name.substr(kScheme.size()) : name);
}

std::string with_scheme(std::string_view name) {
  return std::string(kScheme) + path_of(name).string();
}

// Returns the place of the next start tag or end tag of the section; npos if there is none.
std::size_t next_tag_of(std::string_view text, std::string_view section) {
  for (auto at = text.find('<'); at != text.npos; at = text.find('<', at + 1)) {
    const auto name = at + (text.substr(at + 1).starts_with('/') ? 2 : 1);
    if (text.substr(name).starts_with(section)) return at;
  }
  return text.npos;
}

bool is_folder(std::string_view name) {
  std::error_code ignored;
  return !name.starts_with('<') && fs::is_directory(path_of(name), ignored);
}

}  // namespace

Result<Bytes> load_or_empty(std::string_view uri, std::string_view name, std::size_t max_octets) {
  auto octets = ddssec::load_uri(uri, name, max_octets);
  if (!octets && octets.error().code() == Code::item_empty) return Bytes();
  return octets;
}

std::optional<std::string> cyclonedds_configuration() {
  const char* const uri = std::getenv(kVariable.data());
  if (uri == nullptr || *uri == '\0') return std::nullopt;
  return cyclonedds_configuration(uri);
}

std::optional<std::string> cyclonedds_configuration(std::string_view uri) {
  std::string out;
  while (const auto name = next_name(uri)) {
    if (name->starts_with('<')) return out.append(*name);
    if (is_folder(*name)) continue;
    const auto octets = load_or_empty(with_scheme(*name), kVariable, kMaxOctets);
    if (!octets) return std::nullopt;
    out.append(octets->begin(), octets->end()).push_back('\n');
  }
  return out;
}

std::size_t inline_octets(std::string_view uri) {
  while (const auto name = next_name(uri))
    if (name->starts_with('<')) return name->size();
  return 0;
}

std::vector<std::filesystem::path> files_named_by(std::string_view uri) {
  std::vector<std::filesystem::path> out;
  while (const auto name = next_name(uri)) {
    if (name->starts_with('<')) break;
    out.push_back(path_of(*name));
  }
  return out;
}

std::filesystem::path folder_named_by(std::string_view uri) {
  while (const auto name = next_name(uri))
    if (is_folder(*name)) return path_of(*name);
  return {};
}

std::string without_comments(std::string_view text) {
  std::string out;
  for (;;) {
    const auto begin = text.find("<!--");
    out += text.substr(0, begin);
    if (begin == text.npos) return out;
    const auto end = text.find("-->", begin + 4);
    if (end == text.npos) return out;
    text.remove_prefix(end + 3);
  }
}

std::optional<StartTag> find_tag(std::string_view text, std::string_view name) {
  for (auto at = text.find('<'); at != text.npos; at = text.find('<', at + 1)) {
    const auto rest = text.substr(at + 1);
    if (ascii_lower(rest.substr(0, name.size())) != name) continue;
    const auto after = rest.substr(name.size());
    if (after.empty() || kAfterName.find(after.front()) == kAfterName.npos) continue;
    const auto end = after.find('>');
    if (end == after.npos) return StartTag{after, {}};
    return StartTag{after.substr(0, end), after.substr(end + 1)};
  }
  return std::nullopt;
}

std::vector<std::string_view> values_within(std::string_view text, std::string_view section,
                                            std::string_view name) {
  std::vector<std::string_view> out;
  while (const auto inside = find_tag(text, section)) {
    text = inside->after;
    if (const auto value = find_tag(text.substr(0, next_tag_of(text, section)), name))
      out.push_back(trimmed(value->after.substr(0, value->after.find('<')), kBlanks));
  }
  return out;
}

}  // namespace ddssec::governance::doctor
