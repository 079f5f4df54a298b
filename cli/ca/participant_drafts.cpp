#include "cli/ca/participant_drafts.hpp"

#include "base/tool_code.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

using Links = FileTransaction::Links;

Status put_key_of_ca(FileTransaction& out, const CaRotation& change) {
  DDSSEC_ASSIGN_OR_RETURN(const auto pem, change.ca.key().to_pem(change.passphrase));
  return pem.expose([&](BytesView octets) {
    return out.put(change.ca_in_place.paths.key, octets, 0600, Links::replaced);
  });
}

bool is_unwritable(const Error& error) {
  return error.code() == Code::file_unwritable || error.code() == Code::would_overwrite ||
         error.code() == tool_code::link_untrusted;
}

}  // namespace

bool is_moving(const CaRotation& change) {
  return change.step == RotationStep::move || change.step == RotationStep::end;
}

Status put_ca(FileTransaction& out, const CaRotation& change) {
  const auto& paths = change.ca_in_place.paths;
  const bool is_begin = change.step == RotationStep::begin;
  if (change.step == RotationStep::move || change.is_repeated) return {};
  if (is_begin || change.step == RotationStep::replace)
    DDSSEC_RETURN_IF_ERROR(put_key_of_ca(out, change));
  const auto trust = is_begin ? change.overlap->next_first() : change.trust_pem;
  DDSSEC_RETURN_IF_ERROR(out.put(paths.certificate, as_bytes(trust), 0644, Links::replaced));
  if (!is_begin) return {};
  return out.put_public(overlap_file(paths), overlap_text(*change.overlap));
}

bool is_to_be_replaced(const fs::path& path) {
  std::error_code ignored;
  const auto type = fs::symlink_status(path, ignored).type();
  return type > fs::file_type::not_found && type != fs::file_type::symlink;
}

Status put_if_there(FileTransaction& out, const fs::path& file, const std::string& text) {
  return is_to_be_replaced(file) ? out.put_public(file, text) : Status{};
}

RotationResult empty_result(const CaRotation& change) {
  RotationResult out;
  if (!change.unwritten_hint.empty()) out.unwritten_hint = change.unwritten_hint;
  return out;
}

Error with_unwritten_hint(const Error& error, const std::string& unwritten_hint) {
  auto details = error.details();
  if (details.hint.empty()) details.hint = unwritten_hint;
  return Error(error.code(), std::move(details));
}

Status ParticipantDrafts::note(const AffectedParticipant& participant, const Status& drafted) {
  if (drafted) {
    rotation_.updated.push_back(participant.name);
    return {};
  }
  out_.abandon_folder();
  const auto& error = drafted.error();
  if (error.code() == Code::interrupted) return drafted;
  auto& left = is_unwritable(error) ? rotation_.unwritten : rotation_.doubtful;
  left.push_back(is_unwritable(error) ? with_unwritten_hint(error, rotation_.unwritten_hint)
                                      : error);
  return {};
}

Status ParticipantDrafts::check() const {
  if (!rotation_.updated.empty()) return {};
  for (const auto* left : {&rotation_.doubtful, &rotation_.unwritten})
    if (!left->empty()) return std::unexpected(left->front());
  return {};
}

}  // namespace ddssec::cli
