#include "cli/ca/ca_progress.hpp"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include "cli/ca/logged_certificate.hpp"
#include "cli/ca/signed_documents.hpp"
#include "cli/documents/documents.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/times.hpp"
#include "pki/key_digests.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

template <class Predicate>
std::vector<AffectedParticipant> participants_if(
    const std::vector<AffectedParticipant>& participants, Predicate predicate) {
  std::vector<AffectedParticipant> out;
  std::ranges::copy_if(participants, std::back_inserter(out), predicate);
  return out;
}

std::vector<std::string> names_of(const std::vector<AffectedParticipant>& participants) {
  std::vector<std::string> out;
  for (const auto& participant : participants) out.push_back(participant.name);
  return out;
}

}  // namespace

Result<RotationProgress> RotationProgress::of(const fs::path& given, const std::string& role,
                                              WallTime now) {
  RotationProgress out;
  out.paths_ = ca_paths(given, "identity");
  out.is_identity_ = role == "identity";
  out.now_ = now;
  DDSSEC_ASSIGN_OR_RETURN(out.log_, read_issue_log(out.paths_));
  const auto own = ca_paths(given, role);
  DDSSEC_ASSIGN_OR_RETURN(out.overlap_, read_overlap(own));
  DDSSEC_ASSIGN_OR_RETURN(out.next_, read_certificates(own.certificate));
  if (out.overlap_) out.next_ = out.overlap_->next;
  return out;
}

const fs::path& RotationProgress::ca_file(const AffectedParticipant& participant) const {
  return is_identity_ ? participant.files.identity_ca : participant.files.permissions_ca;
}

bool RotationProgress::is_same_ca(const pki::Certificate& other) const {
  return other.subject() == next_.front().subject() &&
         pki::key_digest(other) == pki::key_digest(next_.front());
}

bool RotationProgress::accepts_successor(const AffectedParticipant& participant) const {
  const auto& file = ca_file(participant);
  if (!path_exists(file)) return true;  // a rotation does not create a missing file
  const auto trusted = read_certificates(file);
  return trusted && std::ranges::any_of(*trusted, [&](const auto& one) { return is_same_ca(one); });
}

bool RotationProgress::trusts_former(const AffectedParticipant& participant) const {
  const auto& file = ca_file(participant);
  if (!path_exists(file)) return false;
  const auto trusted = read_certificates(file);
  return !trusted || std::ranges::any_of(*trusted, [&](const auto& one) {
    return one.subject() == next_.front().subject() && !is_same_ca(one);
  });
}

bool RotationProgress::has_moved(const AffectedParticipant& participant) const {
  const auto& files = participant.files;
  if (is_identity_) {
    const auto certificate = read_certificate(files.certificate);
    return certificate && certificate->is_issued_by(next_.front());
  }
  return std::ranges::all_of(
      std::vector{files.permissions, files.governance},
      [&](const auto& one) { return !path_exists(one) || is_signed_by(one, to_pem(next_), now_); });
}

// A revoked participant gets no certificate of the successor, so it does not count as one that must
// move.
bool RotationProgress::is_revoked(const AffectedParticipant& participant) const {
  if (!is_identity_) return false;
  const auto certificate = read_certificate(participant.files.certificate);
  if (!certificate) return false;
  const auto serial = revoked_serial(*certificate, paths_, log_, NextKey::same);
  return serial && !serial->empty();
}

std::vector<AffectedParticipant> RotationProgress::without_successor(
    const std::vector<AffectedParticipant>& participants) const {
  return participants_if(
      participants, [&](const auto& one) { return !accepts_successor(one) && !is_revoked(one); });
}

std::vector<AffectedParticipant> RotationProgress::not_moved(
    const std::vector<AffectedParticipant>& participants) const {
  return participants_if(participants,
                         [&](const auto& one) { return !has_moved(one) && !is_revoked(one); });
}

std::vector<AffectedParticipant> RotationProgress::not_ended(
    const std::vector<AffectedParticipant>& participants) const {
  return participants_if(participants, [&](const auto& one) {
    const bool is_of_ca = path_exists(ca_file(one)) && accepts_successor(one);
    return (trusts_former(one) || (is_of_ca && !has_moved(one))) && !is_revoked(one);
  });
}

std::vector<AffectedParticipant> RotationProgress::revoked(
    const std::vector<AffectedParticipant>& participants) const {
  return participants_if(participants, [&](const auto& one) { return is_revoked(one); });
}

std::vector<std::string> not_reached(const CaPaths& ca, const AffectedParticipants& known) {
  const auto unreached = read_unreached(ca);
  std::vector<std::string> out;
  std::ranges::copy_if(known.gone, std::back_inserter(out), [&](const std::string& folder) {
    return std::ranges::find(unreached, folder) != unreached.end();
  });
  return out;
}

std::string moved_words(std::size_t moved, std::size_t all) {
  return fmt::format("{} of {} {} moved", moved, count_text(all, "folder"),
                     moved == 1 ? "has" : "have");
}

std::string distribution_before_end(const fs::path& given) {
  if (!path_exists(ca_paths(given, "identity").crl)) return {};
  return fmt::format("ddssec crl distribute --ca {}", given.string());
}

namespace {

struct RemainingSteps {
  bool is_overlap;
  bool is_here_left;  // a folder of this machine has not moved, or not ended
  bool is_elsewhere;  // a folder is not where the log has it
};

std::string next_step(const fs::path& given, const std::string& role,
                      const RemainingSteps& remaining) {
  const auto command = fmt::format("ddssec ca rotate {}", given.string());
  const auto distribution = distribution_before_end(given);
  const auto lists = [&](std::string_view word) {
    if (!remaining.is_overlap || distribution.empty()) return std::string();
    return fmt::format(
        "  {}   {}\n         once, after --move: then --end ends no session of Cyclone DDS\n", word,
        distribution);
  };
  const bool moves = remaining.is_overlap && (remaining.is_here_left || remaining.is_elsewhere);
  const auto step = moves ? "--move" : "--end";
  if (!remaining.is_elsewhere || (remaining.is_overlap && remaining.is_here_left))
    return moves || lists("next").empty()
               ? fmt::format("  next   {} --role {} {}\n", command, role, step)
               : fmt::format("{}  then   {} --role {} {}\n", lists("next"), command, role, step);
  const auto then = remaining.is_overlap ? fmt::format("{}  then   {} --role {} --end\n",
                                                       lists("then"), command, role)
                                         : "";
  return fmt::format(
      "  next   {} PLACES --role {} {}\n"
      "         PLACES: where the folders that are not here are now. A participant on another "
      "machine can also be issued again.\n{}",
      command, role, step, then);
}

}  // namespace

std::string RotationFacts::text() const {
  const auto without = revoked == 0 ? "" : fmt::format(", {} revoked", revoked);
  auto out = until ? fmt::format(
                         "overlap  this is the successor; the former CA counts beside it "
                         "until {}; {}\n",
                         date(*until), moved_words(folders - left.size(), folders) + without)
                   : fmt::format(
                         "rotation not finished: {} still {} what an earlier key of this CA "
                         "issued or signed, or trusts that key\n",
                         count_text(unfinished, "folder"), unfinished == 1 ? "has" : "have");
  for (const auto& one : left) out += fmt::format("  left   {}\n", one);
  for (const auto& one : elsewhere) out += fmt::format("  not here  {}\n", one);
  return out + next;
}

Result<std::optional<RotationFacts>> shown_rotation(const fs::path& given, const std::string& role,
                                                    WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto progress, RotationProgress::of(given, role, now));
  DDSSEC_ASSIGN_OR_RETURN(const auto known, affected_participants(given, now));
  const auto& overlap = progress.overlap();
  const auto left = overlap ? progress.not_moved(known.here) : progress.not_ended(known.here);
  const auto away =
      overlap ? std::vector<std::string>() : not_reached(ca_paths(given, role), known);
  if (!overlap && left.empty() && away.empty()) return std::nullopt;
  const auto revoked = progress.revoked(known.here).size();
  RotationFacts out{.folders = known.here.size() - revoked,
                    .left = names_of(left),
                    .elsewhere = known.elsewhere,
                    .unfinished = left.size() + away.size(),
                    .revoked = revoked};
  if (overlap) {
    out.until = overlap->until;
    for (const auto& one : overlap->former) out.former.push_back(to_hex(one.fingerprint()));
  }
  out.next = next_step(given, role,
                       {.is_overlap = overlap.has_value(),
                        .is_here_left = !left.empty(),
                        .is_elsewhere = overlap ? !known.elsewhere.empty() : !away.empty()});
  return out;
}

}  // namespace ddssec::cli
