#include "base/documents_in_use.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ddssec {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxAnswerTextOctets = 1024;
constexpr std::size_t kMaxAnswerStringOctets = 4096;

std::string shortened(std::string text, std::size_t max_size = kMaxAnswerTextOctets) {
  if (text.size() <= max_size) return text;
  text.resize(max_size);
  return text.append("...");
}

Json json_of(const DocumentPart& part) {
  return {{"subject", shortened(part.subject)},
          {"number", shortened(part.number)},
          {"until", part.until ? Json(to_string(*part.until)) : Json()},
          {"sha256", shortened(part.sha256)}};
}

Json json_of(const std::vector<DocumentPart>& parts) {
  auto out = Json::array();
  for (const auto& part : parts) {
    if (out.size() == DocumentsInUse::kMaxParts) break;
    out.push_back(json_of(part));
  }
  return out;
}

}  // namespace

std::string_view to_string(DocumentKind kind) {
  switch (kind) {
    case DocumentKind::identity_certificate:
      return "identity certificate";
    case DocumentKind::identity_ca:
      return "identity CA";
    case DocumentKind::revocation_list:
      return "revocation list";
    case DocumentKind::renewal_list:
      return "renewal list";
    case DocumentKind::ocsp_response:
      return "OCSP response";
    case DocumentKind::permissions_ca:
      return "permissions CA";
    case DocumentKind::permissions:
      return "permissions";
    case DocumentKind::listed_permissions:
      return "listed permissions";
    case DocumentKind::governance:
      return "governance";
  }
  return "";
}

// False in a forked child. A child must not take mutex_: another thread of the parent may have held
// it at the fork, and no thread of the child releases it.
bool DocumentsInUse::is_of_this_process() const { return ::getpid() == pid_; }

void DocumentsInUse::note_participant(std::int64_t identity, std::string guid,
                                      std::string subject) {
  if (!is_of_this_process()) return;
  const std::scoped_lock lock(mutex_);
  auto& participant = participants_[identity];
  if (!guid.empty()) participant.guid = std::move(guid);
  if (!subject.empty()) participant.subject = std::move(subject);
}

void DocumentsInUse::note(Document& document, const DocumentState& state, WallTime now) {
  if (document.since == WallTime() || document.file != state.file ||
      document.parts != state.parts) {
    document.file = state.file;
    document.parts = state.parts;
    document.since = now;
  }
  document.waiting = state.waiting;
  document.state = std::max(state.state, state.waiting ? FileState::candidate : FileState::current);
  auto& refusal = document.refusal;
  // Copies of an Error share one ErrorDetails object. The same address therefore means that this
  // refusal was stored before, and its time stays.
  const bool is_known =
      refusal && state.refused && &refusal->why.details() == &state.refused->details();
  if (state.refused && !is_known) refusal = Refusal{*state.refused, now, true};
  if (refusal) refusal->stands = state.refused.has_value();
  if (refusal) refusal->waits = state.refused && state.state == FileState::candidate;
}

void DocumentsInUse::note(std::int64_t identity, const std::vector<DocumentState>& states,
                          WallTime now) {
  if (!is_of_this_process()) return;
  const std::scoped_lock lock(mutex_);
  const auto participant = participants_.find(identity);
  if (participant == participants_.end()) return;
  for (const auto& state : states) note(participant->second.documents[state.kind], state, now);
}

void DocumentsInUse::note_end(std::int64_t identity, const Error& why, WallTime now) {
  if (!is_of_this_process()) return;
  const std::scoped_lock lock(mutex_);
  const auto participant = participants_.find(identity);
  if (participant == participants_.end() || participant->second.end) return;
  participant->second.end = Refusal{why, now, true};
}

void DocumentsInUse::forget(std::int64_t identity, std::span<const DocumentKind> kinds) {
  if (!is_of_this_process()) return;
  const std::scoped_lock lock(mutex_);
  const auto participant = participants_.find(identity);
  if (participant == participants_.end()) return;
  for (const auto kind : kinds) participant->second.documents.erase(kind);
  if (participant->second.documents.empty()) participants_.erase(participant);
}

Json DocumentsInUse::json_of(const std::optional<Refusal>& refusal) {
  if (!refusal) return {};
  return {{"at", to_string(refusal->at)},
          {"file", shortened(refusal->why.details().document, kMaxAnswerStringOctets)},
          {"code", static_cast<int>(refusal->why.code())},
          {"name", info(refusal->why.code()).name},
          {"sentence", shortened(refusal->why.to_sentence(), kMaxAnswerStringOctets)},
          {"stands", refusal->stands},
          {"waits", refusal->waits}};
}

std::string DocumentsInUse::json_of(std::int64_t identity, const Participant& participant) {
  auto documents = Json::array();
  for (const auto& [kind, document] : participant.documents) {
    const auto& parts = document.parts;
    documents.push_back(
        {{"kind", to_string(kind)},
         {"file", shortened(document.file, kMaxAnswerStringOctets)},
         {"state", to_string(document.state)},
         {"since", to_string(document.since)},
         {"in_force", ddssec::json_of(parts)},
         {"more", parts.size() - std::min(parts.size(), kMaxParts)},
         {"waiting", document.waiting ? ddssec::json_of(*document.waiting) : Json()},
         {"refused", json_of(document.refusal)}});
  }
  const Json out = {{"identity", identity},
                    {"guid", shortened(participant.guid)},
                    {"subject", shortened(participant.subject)},
                    {"cut_off", json_of(participant.end)},
                    {"documents", std::move(documents)}};
  // Names of files and subjects need not be UTF-8, so invalid octets are replaced.
  return out.dump(-1, ' ', true, Json::error_handler_t::replace);
}

std::string DocumentsInUse::to_json() const {
  const std::scoped_lock lock(mutex_);
  std::string all;
  std::size_t left_out = 0;
  for (const auto& [identity, participant] : participants_) {
    if (all.size() >= kMaxOctets) {
      ++left_out;
      continue;
    }
    if (!all.empty()) all += ',';
    all += json_of(identity, participant);
  }
  return fmt::format(R"({{"schema":"ddssec-status/1","pid":{},"participants":[{}],"left_out":{}}})",
                     pid_, all, left_out);
}

}  // namespace ddssec
