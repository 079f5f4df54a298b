#include "cli/ca/subject_overlap.hpp"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>

#include "cli/inputs/times.hpp"
#include "governance/cyclonedds_subject.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
using governance::cyclonedds_applies_grant;
using governance::pieces_for_cyclonedds;

bool is_same_name(const std::string& a, const std::string& b) {
  const auto one = pki::SubjectName::parse(a), other = pki::SubjectName::parse(b);
  return one && other && one->key() == other->key();
}

Status check_apart(const std::string& subject, const std::string& other, const std::string& where) {
  const bool gets_others_rights = cyclonedds_applies_grant(other, subject);
  if (!gets_others_rights && !cyclonedds_applies_grant(subject, other)) return {};
  if (is_same_name(subject, other)) return {};  // equal names are checked elsewhere
  const auto& gains = gets_others_rights ? subject : other;
  const auto& owner = gets_others_rights ? other : subject;
  return fail(Code::subject_taken,
              {.expected = "a subject whose attributes are not all among another's",
               .found = fmt::format("{} and {}, {}", subject, other, where),
               .note = fmt::format("Cyclone DDS's own plugins compare the certificate's attributes "
                                   "only, and would give {} the permissions of {}",
                                   gains, owner),
               .hint = "choose a subject with an attribute of its own, such as another CN; or "
                       "revoke the other certificate first"});
}

}  // namespace

SubjectsInUse::SubjectsInUse(const pki::IssueLog& log, const fs::path& folder, WallTime now) {
  std::error_code ignored;
  const auto own = fs::absolute(folder, ignored).lexically_normal().string();
  for (const auto& issued : log.issued()) {
    if (issued.revoked || issued.not_after <= now) continue;
    if (!folder.empty() && issued.folder == own && issued.file.empty()) continue;
    add(issued.subject, fmt::format("serial {}, valid until {}, {}", issued.serial,
                                    date(issued.not_after), issued.place()));
  }
}

void SubjectsInUse::add(const std::string& subject, std::string where) {
  const auto pieces = pieces_for_cyclonedds(subject);
  if (pieces.empty()) return;
  for (const auto piece : pieces)
    entries_with_piece_[std::string(piece)].push_back(entries_.size());
  entries_by_first_piece_[std::string(pieces.front())].push_back(entries_.size());
  entries_.push_back({subject, std::move(where)});
}

Status SubjectsInUse::check(const std::string& subject,
                            const std::vector<std::size_t>& entries) const {
  for (const auto i : entries)
    DDSSEC_RETURN_IF_ERROR(check_apart(subject, entries_[i].subject, entries_[i].where));
  return {};
}

Status SubjectsInUse::check(const std::string& subject) const {
  // A subject with all pieces is in the list of each piece, so the shortest list is enough.
  const std::vector<std::size_t>* rarest = nullptr;
  for (const auto piece : pieces_for_cyclonedds(subject)) {
    const auto having = entries_with_piece_.find(std::string(piece));
    if (having == entries_with_piece_.end()) {
      static const std::vector<std::size_t> kNone;
      rarest = &kNone;
      continue;
    }
    if (rarest == nullptr || having->second.size() < rarest->size()) rarest = &having->second;
    // If all pieces of a registered subject are in this one, then its first piece is too. So the
    // subjects that begin with one of these pieces are compared.
    if (const auto beginning = entries_by_first_piece_.find(std::string(piece));
        beginning != entries_by_first_piece_.end())
      DDSSEC_RETURN_IF_ERROR(check(subject, beginning->second));
  }
  return rarest == nullptr ? Status() : check(subject, *rarest);
}

void SubjectsOfFleet::add(const std::string& name, const pki::Certificate& certificate,
                          Report& report) {
  const auto [first, is_new] = names_.try_emplace(pki::SubjectName::of(certificate).key(), name);
  if (is_new) return;
  report.errors.emplace_back(Code::subject_shared,
                             ErrorDetails{.document = fleet_,
                                          .found = fmt::format("{} and {}: {}", first->second, name,
                                                               certificate.subject())});
}

}  // namespace ddssec::cli
