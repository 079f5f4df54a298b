#include "governance/doctor/cyclonedds_configuration.hpp"

#include <cstdlib>

#include "base/source.hpp"
#include "base/text.hpp"

namespace ddssec::governance::doctor {
namespace {

constexpr std::size_t kMostOctets = 1024 * 1024;
constexpr std::string_view kVariable = "CYCLONEDDS_URI";
constexpr std::string_view kBlanks = " \t\r\n";
constexpr std::string_view kAfterName = " \t\r\n/>";

}  // namespace

Result<Bytes> load_or_empty(std::string_view uri, std::string_view name, std::size_t most) {
  auto octets = ddssec::load(uri, name, most);
  if (!octets && octets.error().code() == Code::item_empty) return Bytes();
  return octets;
}

std::optional<std::string> cyclonedds_configuration() {
  const char* const uri = std::getenv(kVariable.data());
  if (uri == nullptr) return std::nullopt;
  return cyclonedds_configuration(uri);
}

std::optional<std::string> cyclonedds_configuration(std::string_view uri) {
  std::string out;
  for (;;) {
    while (!uri.empty() && (uri.front() == ',' || kBlanks.find(uri.front()) != kBlanks.npos))
      uri.remove_prefix(1);
    if (uri.empty()) return out;
    if (uri.front() == '<') return out.append(uri);  // to the end: commas may be in it
    const auto name = uri.substr(0, uri.find(','));
    uri.remove_prefix(name.size());
    if (name.starts_with("file:") && !name.starts_with("file://")) return std::nullopt;
    const auto file = name.starts_with("file:") ? std::string(name) : "file:" + std::string(name);
    const auto octets = load_or_empty(file, kVariable, kMostOctets);
    if (!octets) return std::nullopt;
    out.append(octets->begin(), octets->end()).push_back('\n');
  }
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

}  // namespace ddssec::governance::doctor
