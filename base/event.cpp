#include "base/event.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/text.hpp"

namespace ddssec {
namespace {

/// The number of octets of a peer's name that a line shows.
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
  auto open = text.npos;  // position in `out` of a bracket that is not closed yet
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

// An attacker can cause such an event at little cost.
bool names_an_unproven_peer(const Event& event) {
  const bool names_a_peer = !event.peer_subject.empty() || !event.guid.empty();
  return names_a_peer && event.proof == PeerProof::claimed;
}

/// "2026-12-04T03:00:00.125Z"
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

bool is_news(Code code) {
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

namespace {

/// The same for all participants of one certificate: the first six octets of an authenticated
/// participant's GUID follow from the subject (DDS-Security 1.2, clause 10.3.3).
std::string certificate_of(const Event& event) {
  constexpr std::size_t kSubjectDigits = 12;
  return event.peer_subject.empty() ? event.guid.substr(0, kSubjectDigits) : event.peer_subject;
}

}  // namespace

void RateLimitedSink::raise(const Event& event) {
  const auto& d = event.error.details();
  const auto code = std::to_string(static_cast<int>(event.error.code()));
  const bool is_claimed = names_an_unproven_peer(event);
  const bool is_proven = event.proof == PeerProof::authenticated;
  auto reason = fmt::format("{}\n{}\n{}", code, event.guid, d.document);
  if (!is_claimed) reason += fmt::format("\n{}\n{}\n{}", event.peer_subject, d.field, d.expected);
  // In a notice about the local participant no peer chooses the text, and each change of state is
  // new information.
  if (event.proof == PeerProof::not_a_peer && event.severity == Severity::informational)
    reason += "\n" + d.found;
  // Programs do not print it, so it must not suppress the same event that is not returned.
  if (event.is_returned) reason += "\nreturned";

  const std::lock_guard lock(mutex_);
  const auto now = clock_.monotonic();
  auto& share = is_claimed  ? claimed_
                : is_proven ? share_of(code + "\n" + certificate_of(event), now)
                            : ours_;
  const auto limit = is_claimed ? kMaxClaimed : is_proven ? kMaxOfAPeer : kMaxRemembered;
  const bool passes = has_room(share, limit, reason, now)
                          ? may_pass(share, reason, now)
                          : may_pass(crowded_out_, code + (is_claimed ? " claimed" : ""), now);
  if (passes) next_.raise(event);
}

// If there are too many peers, all further ones use one common share that always counts as full.
RateLimitedSink::Times& RateLimitedSink::share_of(const std::string& peer,
                                                  std::chrono::nanoseconds now) {
  if (const auto known = proven_.find(peer); known != proven_.end()) return known->second;
  if (proven_.size() >= kMaxRemembered) {
    for (auto& [_, share] : proven_) forget_old(share, now);
    std::erase_if(proven_, [](const auto& entry) { return entry.second.empty(); });
  }
  return proven_.size() >= kMaxRemembered ? no_share_ : proven_[peer];
}

bool RateLimitedSink::has_room(Times& share, std::size_t limit, const std::string& reason,
                               std::chrono::nanoseconds now) const {
  if (&share == &no_share_) return false;
  if (share.contains(reason) || share.size() < limit) return true;
  forget_old(share, now);
  return share.size() < limit;
}

bool RateLimitedSink::may_pass(Times& share, const std::string& reason,
                               std::chrono::nanoseconds now) const {
  const auto [known, is_new] = share.try_emplace(reason, now);
  if (!is_new && now - known->second < interval_) return false;
  known->second = now;
  return true;
}

void RateLimitedSink::forget_old(Times& share, std::chrono::nanoseconds now) const {
  std::erase_if(share, [&](const auto& entry) { return now - entry.second >= interval_; });
}

}  // namespace ddssec
