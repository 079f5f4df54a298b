#include "governance/doctor/named_files.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "base/text.hpp"
#include "governance/doctor/configuration_checks.hpp"
#include "governance/doctor/cyclonedds_configuration.hpp"
#include "governance/doctor/expanded_variables.hpp"

namespace ddssec::governance::doctor {
namespace {

// A text can look as if it names a file in each of its lines, and each one is reported.
constexpr std::size_t kMaxNamed = 100;
constexpr std::size_t kMaxNamedOfRole = 10;
// The largest size of a value that is kept of such a text. No path is as long.
constexpr std::size_t kMaxValue = 64 * 1024;

std::string content_of(std::string_view after_tag) {
  return without_escapes(trimmed(after_tag.substr(0, after_tag.find('<')), " \t\r\n"));
}

std::string value_at(std::string_view after_tag) {
  return content_of(after_tag.substr(0, kMaxValue));
}

// True if `tag` begins before `text`, which is a part of the same text.
bool is_before(const StartTag& tag, std::string_view text) {
  return tag.attributes.data() < text.data();
}

const Role* role_of_property(std::string_view name) {
  const auto* const role =
      std::ranges::find(kRoles, name.substr(name.rfind('.') + 1), &Role::property);
  return name.starts_with("dds.sec.") && role != std::end(kRoles) ? role : nullptr;
}

}  // namespace

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

std::vector<NamedFile> named_by_cyclonedds(std::string_view text, const EffectiveSecurity& security,
                                           DomainId domain) {
  std::vector<NamedFile> out;
  if (security.problems.empty() && security.applies) {
    for (const auto* plugin : {&security.authentication, &security.access_control})
      for (const auto& role : kRoles)
        if (const auto* value = *plugin ? (*plugin)->value(role.element) : nullptr)
          out.push_back({&role, expanded_variables(value->text, domain).value_or(value->text)});
    // Measured: with an empty <CRL>, Cyclone DDS starts without a revocation list.
    std::erase_if(out, [](const NamedFile& named) {
      return named.role->judged == &pki::ParticipantFolder::crl && named.value.empty();
    });
    return out;
  }
  for (const auto& role : kRoles) {
    std::size_t found = 0;
    for (auto tag = find_tag(text, role.element); tag && found++ < kMaxNamedOfRole;
         tag = find_tag(tag->after, role.element))
      out.push_back({&role, value_at(tag->after)});
  }
  return out;
}

std::vector<std::filesystem::path> paths_of(const std::vector<NamedFile>& named) {
  std::vector<std::filesystem::path> out;
  for (const auto& [role, value] : named)
    if (auto path = file_named_by(value)) out.emplace_back(*std::move(path));
  return out;
}

std::vector<NamedFile> named_anywhere_by_fastdds(std::string_view text) {
  std::vector<NamedFile> out;
  auto value = find_tag(text, "value");  // the next one after the name
  for (auto tag = find_tag(text, "name"); tag && value && out.size() < kMaxNamed;
       tag = find_tag(tag->after, "name")) {
    if (is_before(*value, tag->after)) value = find_tag(tag->after, "value");
    const auto* const role = role_of_property(content_of(tag->after));
    if (value && role != nullptr) out.push_back({role, value_at(value->after)});
  }
  return out;
}

std::vector<NamedFile> named_by_fastdds(std::string_view text) {
  const auto properties = properties_of_profile(text);
  if (!properties) return named_anywhere_by_fastdds(without_comments(text));
  std::vector<NamedFile> out;
  for (const auto& [name, value] : *properties) {
    const auto* const role = role_of_property(name);
    if (role == nullptr) continue;
    std::erase_if(out, [&](const NamedFile& earlier) { return earlier.role == role; });
    out.push_back({role, value});
  }
  return out;
}

}  // namespace ddssec::governance::doctor
