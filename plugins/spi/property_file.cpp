#include "plugins/spi/property_file.hpp"

#include <algorithm>

#include "base/rollback.hpp"
#include "base/source.hpp"
#include "base/text.hpp"

namespace ddssec::spi {
namespace {

constexpr std::string_view kBlanks = " \t\r";

bool has_control_character(std::string_view text) {
  return std::ranges::any_of(
      text, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
}

Status add_line(std::string_view text, int line, PropertyList& out) {
  const auto content = trimmed(text, kBlanks);
  if (content.empty() || content.front() == '#') return {};
  const auto equals = content.find('=');
  const auto name = trimmed(content.substr(0, equals), kBlanks);
  const auto bad = [&](std::string expected) {
    return fail(
        Code::invalid_property,
        {.line = line, .expected = std::move(expected), .found = std::string(name.substr(0, 64))});
  };
  if (equals == content.npos || name.empty()) return bad("name = value");
  const auto value = trimmed(content.substr(equals + 1), kBlanks);
  if (has_control_character(name) || has_control_character(value))
    return bad("no control characters");
  if (find_property(out, name) != nullptr) return bad("each name once");
  if (out.size() >= kMostPropertiesPerFile) return bad("fewer properties");
  out.push_back({std::string(name), std::string(value), false});
  return {};
}

}  // namespace

Result<PropertyList> parse_properties(std::string_view text) {
  PropertyList out;
  for (int line = 1; !text.empty(); ++line) {
    const auto end = std::min(text.find('\n'), text.size());
    DDSSEC_TRY(add_line(text.substr(0, end), line, out));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return out;
}

Result<PropertyList> read_property_file(const std::filesystem::path& path) {
  const auto name = path.string();
  auto octets = load_secret_octets("file://" + name, name, kMostPropertyFileOctets);
  if (!octets && octets.error().code() == Code::item_empty) return PropertyList{};
  if (!octets) return std::unexpected(std::move(octets).error());
  const Rollback at_the_end([&] { wipe(*octets); });  // one of the values may be a passphrase
  auto properties = parse_properties(as_text(*octets));
  if (!properties) return std::unexpected(properties.error().in(name));
  return properties;
}

}  // namespace ddssec::spi
