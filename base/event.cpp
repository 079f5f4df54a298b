#include "base/event.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/clock.hpp"
#include "base/text.hpp"

namespace ddssec {
namespace {

// The number of octets of a peer's name that a line shows.
constexpr std::size_t kMaxShown = 256;
// The longest text in an event, in octets. Attackers can choose some of these texts.
constexpr std::size_t kMaxOfAText = 1024;

std::string cut(std::string text) {
  if (text.size() > kMaxOfAText) text.replace(kMaxOfAText, text.npos, "...");
  return text;
}

// Replaces quotation marks inside the name, which could end it early.
std::string in_quotation_marks(std::string_view name) {
  std::string out = printable(name.substr(0, kMaxShown));
  std::ranges::replace(out, '"', '\'');
  return '"' + out + (name.size() > kMaxShown ? "...\"" : "\"");
}

// Attackers can choose parts of a line. No such part may look like the code in brackets at the end
// of the line, such as "[malformed 1003]", because log watchers search for that.
std::string without_codes(std::string_view text) {
  std::string out;
  auto open = text.npos;  // the position in `out` of a bracket that is not closed yet
  bool has_gap = false;   // true if a space or a non-ASCII octet followed it
  for (const char c : text) {
    if (c == ']' && open != text.npos) {
      if (has_gap && out.back() >= '0' && out.back() <= '9') out.replace(open, 1, "\\x5b");
      open = text.npos;
    }
    if (c == '[') {
      open = out.size();
      has_gap = false;
    }
    has_gap = has_gap || c == ' ' || static_cast<unsigned char>(c) >= 0x80;
    out += c;
  }
  return out;
}

// Formats a time as "2026-12-04T03:00:00.125Z".
std::string in_utc(std::chrono::nanoseconds at) {
  const auto whole = std::chrono::floor<std::chrono::seconds>(at);
  const auto thousandths = std::chrono::floor<std::chrono::milliseconds>(at - whole).count();
  auto out = ddssec::to_string(WallTime(whole));
  out.pop_back();
  return fmt::format("{}.{:03}Z", out, thousandths);
}

}  // namespace

std::string Event::to_line() const {
  std::string who;
  if (!peer_subject.empty())
    who += fmt::format(" peer {}{}", proof == PeerProof::claimed ? "claims to be " : "",
                       in_quotation_marks(peer_subject));
  if (!guid.empty()) who += fmt::format(" guid {}", printable(guid));
  const auto line = fmt::format("{}:{} {}", to_string(severity), who, error.to_sentence());
  const auto code = line.rfind(" [");
  return without_codes(line.substr(0, code)) + line.substr(code);
}

std::string Event::to_json(std::chrono::nanoseconds at) const {
  const auto& row = info(error.code());
  const auto& d = error.details();
  nlohmann::ordered_json json = {{"time", in_utc(at)},
                                 {"code", static_cast<int>(error.code())},
                                 {"name", row.name},
                                 {"severity", to_string(severity)},
                                 {"peer_subject", cut(peer_subject)},
                                 {"peer_authenticated", proof == PeerProof::authenticated},
                                 {"guid", cut(guid)},
                                 {"document", cut(d.document)},
                                 {"line", d.line},
                                 {"field", cut(d.field)},
                                 {"expected", cut(d.expected)},
                                 {"found", cut(d.found)},
                                 {"hint", cut(error.hint())},
                                 {"sentence", cut(error.to_sentence())}};
  // Peers choose some of these octets. Octets that are not UTF-8 are replaced instead of throwing,
  // and control characters are escaped for terminals.
  return json.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

bool is_always_shown(Code code) {
  switch (code) {
    case Code::rtps_joined:
    case Code::rtps_peer_authenticated:
    case Code::identity_renewed:
    case Code::identity_ca_renewed:
    case Code::peer_identity_renewed:
    case Code::permissions_renewed:
    case Code::permissions_ca_renewed:
    case Code::peer_permissions_renewed:
    case Code::governance_changing:
    case Code::governance_renewed:
    case Code::crl_renewed:
    case Code::ocsp_response_renewed:
      return true;
    default:
      return false;
  }
}

}  // namespace ddssec
