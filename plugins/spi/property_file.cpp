#include "plugins/spi/property_file.hpp"

#include <algorithm>

#include "base/rollback.hpp"
#include "base/text.hpp"
#include "base/uri_source.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {
namespace {

constexpr std::string_view kBlanks = " \t\r";
// The octets that some editors put before the first line of a UTF-8 text.
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
// The largest edit distance at which a known name is proposed.
constexpr std::size_t kMaxDifferences = 3;
constexpr std::size_t kMaxNameOctets = 64;

bool has_control_character(std::string_view text) {
  return std::ranges::any_of(
      text, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
}

// Returns the known name that is most similar to `name`; empty if none is similar enough.
std::string_view nearest(std::string_view name) {
  const auto lower = ascii_lower(name.substr(0, kMaxNameOctets));
  std::size_t least = kMaxDifferences + 1;
  std::string_view best;
  for (const auto known : property::kOfParticipants) {
    const auto differences = edit_distance(lower, known);
    if (differences >= least) continue;
    least = differences;
    best = known;
  }
  return best;
}

// The path may point to any file on the machine, and a line of secrets can contain an equals sign
// too. So an error quotes only text that looks like a property name.
std::string quoted(std::string_view name) {
  constexpr std::string_view kBeginnings[] = {"dds.sec.", "org.ddssec.", "org.eclipse.cyclonedds."};
  const auto lower = ascii_lower(name.substr(0, kMaxNameOctets));
  const bool looks_like_one =
      !nearest(name).empty() || std::ranges::any_of(kBeginnings, [&](std::string_view beginning) {
        return lower.starts_with(beginning);
      });
  return looks_like_one ? std::string(name.substr(0, kMaxNameOctets)) : "another name";
}

Status check_known(std::string_view name, int line) {
  if (std::ranges::find(property::kOfParticipants, name) != std::end(property::kOfParticipants))
    return {};
  const auto meant = nearest(name);
  const bool is_case = ascii_lower(name) == meant;
  return fail(Code::property_unknown,
              {.line = line,
               .expected = std::string(meant),
               .found = quoted(name),
               .note = is_case ? "upper and lower case differ in names" : ""});
}

Status add_line(std::string_view text, int line, PropertyList& out) {
  const auto content = trimmed(text, kBlanks);
  if (content.empty() || content.front() == '#') return {};
  const auto equals = content.find('=');
  const auto name = trimmed(content.substr(0, equals), kBlanks);
  const auto bad = [&](std::string expected, std::string found) {
    return fail(Code::invalid_property,
                {.line = line, .expected = std::move(expected), .found = std::move(found)});
  };
  if (equals == content.npos) return bad("name = value", "no equals sign");
  if (name.empty()) return bad("name = value", "no name");
  const auto value = trimmed(content.substr(equals + 1), kBlanks);
  if (has_control_character(name) || has_control_character(value))
    return bad("no control characters", "one");
  DDSSEC_RETURN_IF_ERROR(check_known(name, line));
  if (find_property(out, name) != nullptr) return bad("each name once", std::string(name));
  out.push_back({std::string(name), std::string(value), false});
  return {};
}

}  // namespace

Result<PropertyList> parse_properties(std::string_view text) {
  PropertyList out;
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  for (int line = 1; !text.empty(); ++line) {
    const auto end = std::min(text.find('\n'), text.size());
    DDSSEC_RETURN_IF_ERROR(add_line(text.substr(0, end), line, out));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return out;
}

Result<PropertyList> read_property_file(const std::filesystem::path& path) {
  const auto name = path.string();
  auto octets = load_secret_octets("file://" + name, name, kMaxPropertyFileOctets);
  if (!octets && octets.error().code() == Code::item_empty) return PropertyList{};
  if (!octets) return std::unexpected(std::move(octets).error());
  const Rollback at_the_end([&] { wipe(*octets); });  // A value may be a passphrase.
  return with_default_document(parse_properties(as_text(*octets)), name);
}

}  // namespace ddssec::spi
