#include "pki/signing_log.hpp"

#include <algorithm>
#include <limits>

#include <nlohmann/json.hpp>

#include "base/hash.hpp"
#include "pki/issue_log.hpp"
#include "pki/key_digests.hpp"

namespace ddssec::pki {
using ddssec::to_string;

namespace {

using LogJson = nlohmann::ordered_json;

std::string member(const LogJson& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

// Returns 0 if the value is not a revision number.
std::uint32_t revision_in(const LogJson& value) {
  if (!value.is_number_unsigned()) return 0;
  const auto number = value.get<std::uint64_t>();
  return number <= std::numeric_limits<std::uint32_t>::max() ? static_cast<std::uint32_t>(number)
                                                             : 0;
}

std::string entry(const std::string& ca, const std::string& document) {
  return ca + ' ' + document;
}

}  // namespace

std::string document_digest(BytesView text) {
  std::string out(as_text(text));
  std::erase(out, '\r');
  return to_hex(sha256(as_bytes(out)));
}

SigningLog SigningLog::parse(BytesView text) {
  SigningLog log;
  auto rest = as_text(text);
  for (int line = 1;; ++line) {
    if (rest.empty()) return log;
    const auto end = std::min(rest.find('\n'), rest.size());
    if (!log.add_line(rest.substr(0, end))) log.unreadable_.push_back(line);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
}

bool SigningLog::add_line(std::string_view line) {
  constexpr std::size_t kDigits = 64;  // the digits of SHA-256
  if (line.size() > kMaxLogLineOctets) return false;
  const auto object = LogJson::parse(line, nullptr, false);
  if (!object.is_object() || member(object, "event") != "signed") return false;
  const auto document = member(object, "sha256"), ca = member(object, "ca"),
             file = member(object, "file");
  if (document.size() != kDigits || ca.size() != kDigits) return false;
  signed_.insert(entry(ca, document));
  files_of_[document].push_back(file);
  if (auto old = member(object, "extends"); old.size() == kDigits)
    extends_[document] = std::move(old);
  last_in_[file] = document;
  line_of_[document] = ++lines_;
  if (const auto found = object.find("revision"); found != object.end())
    last_revision_ = std::max(last_revision_, revision_in(*found));
  return true;
}

bool SigningLog::is_last_of(const std::string& file, BytesView text) const {
  const auto found = last_in_.find(file);
  return found != last_in_.end() && found->second == document_digest(text);
}

// A log that was edited by hand may say that two documents extend each other. The number of steps
// is limited so that such a cycle ends.
bool SigningLog::is_current_in(const std::string& file, const std::string& document) const {
  auto at = last_in_.find(file);
  if (at == last_in_.end()) return false;
  const auto* text = &at->second;
  for (std::size_t steps = 0; steps <= extends_.size() && *text != document; ++steps) {
    const auto older = extends_.find(*text);
    if (older == extends_.end()) return false;
    text = &older->second;
  }
  return *text == document;
}

bool SigningLog::is_superseded_in(const std::string& file, const std::string& document) const {
  const auto last = last_in_.find(file);
  if (last == last_in_.end() || is_current_in(file, document)) return false;
  const auto& files = files_of_.at(document);
  return std::ranges::find(files, file) != files.end() ||
         line_of_.at(document) < line_of_.at(last->second);
}

// If a new CA signs the same text again, that supersedes nothing: the old document is used until
// the new one is in place.
SigningLog::Standing SigningLog::standing(BytesView text, const Certificate& ca,
                                          const std::vector<std::string>& files) const {
  const auto document = document_digest(text);
  const bool is_signed = std::ranges::any_of(KeyDigests(ca).all(), [&](const auto& key) {
    return signed_.contains(entry(key, document));
  });
  if (!is_signed) return Standing::unknown;
  const bool is_current =
      std::ranges::any_of(files_of_.at(document),
                          [&](const auto& file) { return is_current_in(file, document); }) &&
      std::ranges::none_of(files,
                           [&](const auto& file) { return is_superseded_in(file, document); });
  return is_current ? Standing::current : Standing::superseded;
}

std::string SigningLog::signed_line(BytesView text, const Certificate& ca, std::string_view file,
                                    WallTime now, BytesView extended) {
  LogJson object = {{"event", "signed"},
                    {"time", to_string(now)},
                    {"sha256", document_digest(text)},
                    {"ca", key_digest(ca)},
                    {"file", file}};
  if (!extended.empty()) object["extends"] = document_digest(extended);
  return object.dump(-1, ' ', false, LogJson::error_handler_t::replace) + "\n";
}

std::string SigningLog::with_revision(const std::string& lines, std::uint32_t revision) {
  std::string out;
  for (std::size_t begin = 0; begin < lines.size();) {
    const auto end = std::min(lines.find('\n', begin), lines.size());
    auto object = LogJson::parse(lines.substr(begin, end - begin));
    object["revision"] = revision;
    out += object.dump(-1, ' ', false, LogJson::error_handler_t::replace) + "\n";
    begin = end + 1;
  }
  return out;
}

}  // namespace ddssec::pki
