#include "governance/fastdds_subject.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "base/text.hpp"

namespace ddssec::governance {
namespace {

std::vector<std::string_view> split(std::string_view text) {
  std::vector<std::string_view> parts;
  for (;;) {
    const auto end = text.find(',');
    parts.push_back(text.substr(0, end));
    if (end == text.npos) return parts;
    text.remove_prefix(end + 1);
  }
}

// Fast DDS treats only spaces as blanks.
std::string_view without_spaces(std::string_view part) { return trimmed(part, " "); }

}  // namespace

bool fastdds_takes(std::string_view grant, std::string_view certificate) {
  const auto parts_of = [](std::string_view name) {
    auto parts = split(name);
    parts.erase(std::ranges::find(parts, ""), parts.end());
    return parts;
  };
  return std::ranges::equal(parts_of(grant), parts_of(certificate), {}, without_spaces,
                            without_spaces);
}

bool fastdds3_applies_grant(std::string_view grant, std::string_view certificate) {
  const auto parts_of = [](std::string_view name) {
    std::vector<std::string> out;
    for (const auto part : split(name)) {
      const auto equals = part.find('=');
      if (equals == part.npos) break;
      out.push_back(std::string(without_spaces(part.substr(0, equals))) + '=' +
                    std::string(without_spaces(part.substr(equals + 1))));
    }
    std::ranges::sort(out);
    return out;
  };
  return parts_of(grant) == parts_of(certificate);
}

}  // namespace ddssec::governance
