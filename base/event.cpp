#include "base/event.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ddssec {

std::string Event::to_line() const {
  std::string who;
  if (!peer_subject.empty()) who += fmt::format(" peer \"{}\"", peer_subject);
  if (!guid.empty()) who += fmt::format(" guid {}", guid);
  return fmt::format("{}:{} {}", to_string(severity), who, error.to_sentence());
}

std::string Event::to_json() const {
  const auto& row = info(error.code());
  const auto& d = error.details();
  nlohmann::ordered_json json = {{"code", static_cast<int>(error.code())},
                                 {"name", row.name},
                                 {"severity", to_string(severity)},
                                 {"peer_subject", peer_subject},
                                 {"guid", guid},
                                 {"document", d.document},
                                 {"line", d.line},
                                 {"field", d.field},
                                 {"expected", d.expected},
                                 {"found", d.found},
                                 {"hint", row.hint},
                                 {"sentence", error.to_sentence()}};
  // Peers choose some of these octets: what is not UTF-8 is replaced, never thrown about.
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void RateLimitedSink::raise(const Event& event) {
  const auto& d = event.error.details();
  const auto key =
      fmt::format("{}\n{}\n{}\n{}\n{}\n{}\n{}", static_cast<int>(event.error.code()),
                  event.peer_subject, event.guid, d.document, d.field, d.expected, d.found);
  if (may_pass(key)) next_.raise(event);
}

bool RateLimitedSink::may_pass(const std::string& key) {
  const std::lock_guard lock(mutex_);
  const auto now = clock_.monotonic();
  auto known = last_.find(key);
  if (known == last_.end() && last_.size() >= kMostRemembered) {
    std::erase_if(last_, [&](const auto& entry) { return now - entry.second >= interval_; });
    if (last_.size() >= kMostRemembered) known = last_.try_emplace("", now - interval_).first;
  }
  if (known == last_.end()) return last_.emplace(key, now).second;
  if (now - known->second < interval_) return false;
  known->second = now;
  return true;
}

}  // namespace ddssec
