#include "base/event.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/text.hpp"

namespace ddssec {
namespace {

/// The longest part of a peer's name that a line shows.
constexpr std::size_t kMostShown = 256;

// Without quotation marks of its own, which could end it early.
std::string in_quotation_marks(std::string_view name) {
  std::string out = printable(name.substr(0, kMostShown));
  std::ranges::replace(out, '"', '\'');
  return '"' + out + (name.size() > kMostShown ? "...\"" : "\"");
}

// Such an event is cheap for an attacker to cause.
bool names_an_unproven_peer(const Event& event) {
  const bool names_a_peer = !event.peer_subject.empty() || !event.guid.empty();
  return names_a_peer && event.proof == PeerProof::claimed;
}

}  // namespace

std::string Event::to_line() const {
  std::string who;
  if (!peer_subject.empty())
    who += fmt::format(" peer {}{}", proof == PeerProof::claimed ? "claims to be " : "",
                       in_quotation_marks(peer_subject));
  if (!guid.empty()) who += fmt::format(" guid {}", printable(guid));
  return fmt::format("{}:{} {}", to_string(severity), who, error.to_sentence());
}

std::string Event::to_json() const {
  const auto& row = info(error.code());
  const auto& d = error.details();
  nlohmann::ordered_json json = {{"code", static_cast<int>(error.code())},
                                 {"name", row.name},
                                 {"severity", to_string(severity)},
                                 {"peer_subject", peer_subject},
                                 {"peer_authenticated", proof == PeerProof::authenticated},
                                 {"guid", guid},
                                 {"document", d.document},
                                 {"line", d.line},
                                 {"field", d.field},
                                 {"expected", d.expected},
                                 {"found", d.found},
                                 {"hint", row.hint},
                                 {"sentence", error.to_sentence()}};
  // Peers choose some of these octets: what is not UTF-8 is replaced, never thrown about, and what
  // a terminal would obey is escaped.
  return json.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

void RateLimitedSink::raise(const Event& event) {
  const auto& d = event.error.details();
  const bool is_claimed = names_an_unproven_peer(event);
  auto key =
      fmt::format("{}\n{}\n{}", static_cast<int>(event.error.code()), event.guid, d.document);
  if (!is_claimed) key += fmt::format("\n{}\n{}\n{}", event.peer_subject, d.field, d.expected);
  // A notice about ourselves: no peer chooses what it says, and each change of state is news.
  if (event.proof == PeerProof::not_a_peer && event.severity == Severity::informational)
    key += "\n" + d.found;
  const bool passes = is_claimed ? may_pass(last_claimed_, kMostClaimed, key)
                                 : may_pass(last_, kMostRemembered, key);
  if (passes) next_.raise(event);
}

bool RateLimitedSink::may_pass(Times& last, std::size_t most, const std::string& key) {
  const std::lock_guard lock(mutex_);
  const auto now = clock_.monotonic();
  auto known = last.find(key);
  if (known == last.end() && last.size() >= most) {
    std::erase_if(last, [&](const auto& entry) { return now - entry.second >= interval_; });
    if (last.size() >= most) known = last.try_emplace("", now - interval_).first;
  }
  if (known == last.end()) return last.emplace(key, now).second;
  if (now - known->second < interval_) return false;
  known->second = now;
  return true;
}

}  // namespace ddssec
