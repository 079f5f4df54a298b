#include "pki/issue_log.hpp"

#include <algorithm>
#include <unordered_set>

#include <nlohmann/json.hpp>

#include "base/hash.hpp"

namespace ddssec::pki {
using ddssec::to_string;

namespace {

using Json = nlohmann::ordered_json;

std::string line_of(const Json& object) {
  return object.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::unexpected<Error> malformed_line_error(std::string note) {
  return fail(Code::issue_log_malformed, {.note = std::move(note)});
}

// Parses a time such as "2026-11-21T00:00:00Z", in no other form than to_string(WallTime) writes.
std::optional<WallTime> time_from(const std::string& text) {
  int part[6] = {};
  constexpr std::size_t kAt[6] = {0, 5, 8, 11, 14, 17};
  if (text.size() != 20) return std::nullopt;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t at = kAt[i]; at < kAt[i] + (i == 0 ? 4 : 2); ++at) {
      if (text[at] < '0' || '9' < text[at]) return std::nullopt;
      part[i] = part[i] * 10 + (text[at] - '0');
    }
  const std::chrono::year_month_day day{std::chrono::year(part[0]),
                                        std::chrono::month(static_cast<unsigned>(part[1])),
                                        std::chrono::day(static_cast<unsigned>(part[2]))};
  if (!day.ok()) return std::nullopt;
  const WallTime time = std::chrono::sys_days(day) + std::chrono::hours(part[3]) +
                        std::chrono::minutes(part[4]) + std::chrono::seconds(part[5]);
  return to_string(time) == text ? std::optional(time) : std::nullopt;
}

std::string text_of(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

Result<WallTime> time_of(const Json& object, const char* name) {
  const auto time = time_from(text_of(object, name));
  if (!time) return malformed_line_error(std::string(name) + " is no time");
  return *time;
}

Result<std::string> serial_of(const Json& object) {
  auto serial = text_of(object, "serial");
  const auto is_digit = [](char c) { return ('0' <= c && c <= '9') || ('A' <= c && c <= 'F'); };
  constexpr std::size_t kMaxDigits = 64;
  if (serial.empty() || serial.size() > kMaxDigits || !std::ranges::all_of(serial, is_digit))
    return malformed_line_error("serial is no serial number");
  return serial;
}

}  // namespace

IssueLog IssueLog::parse(BytesView text) {
  IssueLog log;
  auto rest = as_text(text);
  for (int line = 1;; ++line) {
    if (rest.empty()) return log;
    const auto end = std::min(rest.find('\n'), rest.size());
    const auto added = log.add_line(rest.substr(0, end));
    if (!added) {
      auto details = added.error().details();
      details.line = line;
      log.unreadable_.emplace_back(Code::issue_log_malformed, std::move(details));
    }
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
}

// Adds a certificate, or notes the new place of one that is known. The serial number alone does not
// prove that it is the same certificate.
void IssueLog::add_issued(IssuedCertificate one) {
  const auto [at, is_new] = issued_by_serial_.emplace(one.serial, issued_.size());
  if (is_new) return issued_.push_back(std::move(one));
  auto& known = issued_[at->second];
  if (one.sha256.empty() || one.sha256 != known.sha256 || one.folder.empty()) return;
  known.folder = std::move(one.folder);
  known.file = std::move(one.file);
}

Status IssueLog::add_line(std::string_view line) {
  if (line.size() > kMaxLogLineOctets) return malformed_line_error("the line is too long");
  const auto object = Json::parse(line, nullptr, false);
  if (!object.is_object()) return malformed_line_error("the line is no JSON object");
  DDSSEC_ASSIGN_OR_RETURN(auto serial, serial_of(object));
  const auto event = text_of(object, "event");
  if (const auto time = time_from(text_of(object, "time"))) times_.push_back(*time);
  if (event == "issued") {
    DDSSEC_ASSIGN_OR_RETURN(const auto not_after, time_of(object, "not_after"));
    IssuedCertificate one{.serial = serial,
                          .subject = text_of(object, "subject"),
                          .not_after = not_after,
                          .folder = text_of(object, "folder"),
                          .file = text_of(object, "file"),
                          .sha256 = text_of(object, "sha256"),
                          .key = text_of(object, "key")};
    add_issued(std::move(one));
    return {};
  }
  if (event != "revoked") return malformed_line_error("event is neither issued nor revoked");
  const auto reason = revocation_reason_from(text_of(object, "reason"));
  if (!reason) return malformed_line_error("reason is none of RFC 5280");
  DDSSEC_ASSIGN_OR_RETURN(const auto time, time_of(object, "time"));
  const Revocation revocation{serial, time, *reason};
  if (auto key = text_of(object, "key"); !key.empty())
    revoked_keys_.emplace(std::move(key), serial);
  if (!revoked_by_serial_.emplace(serial, revocations_.size()).second) return {};
  revocations_.push_back(revocation);
  const auto issued = issued_by_serial_.find(serial);
  if (issued != issued_by_serial_.end()) issued_[issued->second].revoked = revocation;
  return {};
}

std::vector<std::string> IssueLog::places() const {
  std::vector<std::string> out;
  std::unordered_set<std::string> seen;
  for (const auto& one : issued_)
    if (!one.folder.empty() && !one.revoked && seen.insert(one.place()).second)
      out.push_back(one.place());
  return out;
}

std::vector<std::string> IssueLog::revoked_places() const {
  const auto valid = places();
  std::unordered_set<std::string> seen(valid.begin(), valid.end());
  std::vector<std::string> out;
  for (const auto& one : issued_)
    if (!one.folder.empty() && seen.insert(one.place()).second) out.push_back(one.place());
  return out;
}

std::unordered_set<std::string> IssueLog::present_places() const {
  std::unordered_set<std::string> out;
  std::unordered_map<std::string, const IssuedCertificate*> last;
  for (const auto& one : issued_) {
    if (one.folder.empty()) continue;
    if (one.key.empty())
      out.insert(one.place());
    else
      last[one.key + one.subject] = &one;
  }
  for (const auto& [participant, one] : last) out.insert(one->place());
  return out;
}

std::optional<WallTime> IssueLog::latest_before(WallTime limit) const {
  std::optional<WallTime> out;
  for (const auto time : times_)
    if (time < limit) out = std::max(out.value_or(time), time);
  return out;
}

Status IssueLog::add(const Revocation& revocation) {
  const auto line = revoked_line(revocation);
  return add_line(std::string_view(line).substr(0, line.size() - 1));
}

const IssuedCertificate* IssueLog::find(std::string_view serial) const {
  const auto found = issued_by_serial_.find(std::string(serial));
  return found == issued_by_serial_.end() ? nullptr : &issued_[found->second];
}

bool IssueLog::is_revoked(std::string_view serial) const {
  return revoked_by_serial_.contains(std::string(serial));
}

std::string IssueLog::revoked_serial(const KeyDigests& key) const {
  for (const auto& one : issued_)
    if (one.revoked && key.contains(one.key)) return one.serial;
  for (const auto& [digest, serial] : revoked_keys_)
    if (key.contains(digest)) return serial;
  return {};
}

std::string IssueLog::issued_line(const Certificate& certificate, std::string_view folder,
                                  WallTime now, std::string_view file) {
  Json line = {{"event", "issued"},
               {"time", to_string(now)},
               {"serial", certificate.serial()},
               {"subject", certificate.subject()},
               {"not_after", to_string(certificate.not_after())},
               {"sha256", to_hex(certificate.fingerprint())},
               {"key", key_digest(certificate)},
               {"folder", folder}};
  if (file != kCertificateFile) line["file"] = file;
  return line_of(line);
}

std::string IssueLog::revoked_line(const Revocation& revocation, std::string_view key) {
  Json line = {{"event", "revoked"},
               {"time", to_string(revocation.time)},
               {"serial", revocation.serial},
               {"reason", to_string(revocation.reason)}};
  if (!key.empty()) line["key"] = key;
  return line_of(line);
}

}  // namespace ddssec::pki
