#include "plugins/cryptography/passphrase.hpp"

#include <algorithm>
#include <charconv>

#include "base/uri_source.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::cryptography {
namespace {

constexpr std::size_t kMaxPassphraseOctets = Passphrase::Text::capacity;
constexpr std::size_t kMaxLineOctets = 10 + 1 + kMaxPassphraseOctets + 2;
using Lines = Secret<struct PassphraseLinesTag, kMaxLineOctets*(kMaxExtraPassphrases + 1)>;

// The place of a passphrase. Its text is never part of an error.
struct Place {
  std::string_view property;
  int line;

  std::unexpected<Error> line_error(std::string expected, std::string found) const {
    return fail(Code::invalid_property, {.document = std::string(property),
                                         .line = line,
                                         .expected = std::move(expected),
                                         .found = std::move(found)});
  }
};

bool is_printable(char c) { return c >= ' ' && c <= '~'; }

Result<std::uint32_t> parse_id(std::string_view text, const Place& place) {
  std::uint32_t id = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
  if (error != std::errc() || end != text.data() + text.size())
    return place.line_error("ID:PASSPHRASE with a decimal ID from 0 to 4294967294", "no such ID");
  if ((id & 0xff) == 0xff)
    return place.line_error("an ID that is not reserved",
                            std::to_string(id) + ", whose last octet is 255");
  return id;
}

Result<Passphrase> parse_line(std::string_view line, const Place& place) {
  const auto colon = line.find(':');
  if (colon == line.npos) return place.line_error("ID:PASSPHRASE", "no colon");
  DDSSEC_ASSIGN_OR_RETURN(const auto id, parse_id(line.substr(0, colon), place));
  const auto text = line.substr(colon + 1);
  if (text.empty() || text.size() > kMaxPassphraseOctets)
    return place.line_error("1 to " + std::to_string(kMaxPassphraseOctets) + " characters",
                            std::to_string(text.size()));
  if (!std::ranges::all_of(text, is_printable) || text.front() == ' ' || text.back() == ' ')
    return place.line_error("printable ASCII without a blank at either end", "something else");
  DDSSEC_ASSIGN_OR_RETURN(auto secret, Passphrase::Text::copy_of(as_bytes(text)));
  return Passphrase{id, std::move(secret)};
}

// The same passphrase twice is allowed: it may be both the one to send with and one that is
// accepted.
Status add(Passphrase passphrase, const Place& place, std::vector<Passphrase>& out) {
  const auto known = std::ranges::find(out, passphrase.id, &Passphrase::id);
  if (known == out.end())
    out.push_back(std::move(passphrase));
  else if (known->text != passphrase.text)
    return place.line_error("another ID for another passphrase", std::to_string(passphrase.id));
  return {};
}

Status parse_lines(std::string_view text, std::string_view property, std::size_t limit,
                   std::vector<Passphrase>& out) {
  constexpr std::string_view kEnds = "\r\n";
  std::size_t found = 0;
  for (int line = 1; !text.empty(); ++line) {
    const auto size = std::min(text.find_first_of(kEnds), text.size());
    const Place place{property, line};
    if (size > 0) {
      if (++found > limit)
        return place.line_error(
            "at most " + std::to_string(limit) + (limit == 1 ? " line" : " lines"), "more");
      DDSSEC_ASSIGN_OR_RETURN(auto passphrase, parse_line(text.substr(0, size), place));
      DDSSEC_RETURN_IF_ERROR(add(std::move(passphrase), place, out));
    }
    const bool pair = text.substr(size).starts_with("\r\n");
    text.remove_prefix(std::min(size + (pair ? 2 : 1), text.size()));
  }
  if (found == 0) return Place{property, 0}.line_error("ID:PASSPHRASE", "nothing");
  return {};
}

Status load(std::string_view uri, std::string_view property, std::size_t limit,
            std::vector<Passphrase>& out) {
  DDSSEC_ASSIGN_OR_RETURN(const auto lines, load_secret<Lines>(uri, property));
  return lines.expose(
      [&](BytesView octets) { return parse_lines(as_text(octets), property, limit, out); });
}

void warn_if_exposed(std::string_view uri, std::string_view property, EventSink& events) {
  if (readable_by_others(uri))
    events.raise(Event(Error(Code::psk_passphrase_exposed,
                             {.document = std::string(property), .found = std::string(uri)})));
}

}  // namespace

PassphraseFiles::PassphraseFiles(const spi::PropertyList& properties,
                                 std::chrono::nanoseconds poll_interval)
    : own_(spi::property_value(properties, spi::property::kPskPassphrase), poll_interval),
      extra_(spi::property_value(properties, spi::property::kPskExtraPassphrases), poll_interval),
      has_extra_(!spi::property_value(properties, spi::property::kPskExtraPassphrases).empty()) {}

Result<std::vector<Passphrase>> PassphraseFiles::load(EventSink& events) const {
  namespace property = spi::property;
  std::vector<Passphrase> out;
  DDSSEC_RETURN_IF_ERROR(cryptography::load(own_.uri(), property::kPskPassphrase, 1, out));
  if (has_extra_)
    DDSSEC_RETURN_IF_ERROR(cryptography::load(extra_.uri(), property::kPskExtraPassphrases,
                                              kMaxExtraPassphrases, out));
  warn_if_exposed(own_.uri(), property::kPskPassphrase, events);
  warn_if_exposed(extra_.uri(), property::kPskExtraPassphrases, events);
  return out;
}

bool PassphraseFiles::may_have_changed(std::chrono::nanoseconds now) {
  const bool own = own_.may_have_changed(now);
  return extra_.may_have_changed(now) || own;
}

void PassphraseFiles::force_change() {
  own_.force_change();
  extra_.force_change();
}

std::string PassphraseFiles::place_of(std::string_view property) const {
  const auto& file = property == spi::property::kPskPassphrase ? own_ : extra_;
  return file_named_by(file.uri()).value_or(std::string(property));
}

}  // namespace ddssec::cryptography
