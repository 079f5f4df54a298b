#include "cli/ca/list_dates.hpp"

#include <algorithm>
#include <sys/stat.h>

#include <fmt/format.h>

#include "cli/ca/participant_places.hpp"
#include "cli/ca/revocation_lists.hpp"
#include "cli/documents/documents.hpp"
#include "cli/inputs/files.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// The latest of the times that were added, each cut to a limit.
class LatestTime {
 public:
  explicit LatestTime(WallTime limit) : limit_(limit) {}

  void add(WallTime time) {
    time = std::min(time, limit_);
    latest_ = std::max(latest_.value_or(time), time);
  }
  // Ignores a later time, because a command that ran with a wrong clock may have written it.
  void add_if_before(WallTime time) {
    if (time < limit_) add(time);
  }
  void add_file(const fs::path& file) {
    struct stat found {};
    if (::stat(file.c_str(), &found) == 0) add(WallTime(std::chrono::seconds(found.st_mtime)));
  }
  bool is_near() const { return !latest_ || limit_ - *latest_ <= kMaxRest; }
  WallTime time() const { return latest_.value_or(limit_); }

 private:
  WallTime limit_;
  std::optional<WallTime> latest_;
};

Result<LatestTime> latest_known(WallTime limit, const CaPaths& ca) {
  LatestTime out(limit);
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, read_certificate(ca.certificate));
  out.add(certificate.not_before());
  out.add_file(ca.certificate);
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_issue_log(ca));
  if (const auto time = log.latest_before(limit)) out.add(*time);
  DDSSEC_ASSIGN_OR_RETURN(const auto crls, read_crls(ca.crl));
  for (const auto& list : crls) out.add_if_before(list.this_update());
  if (out.is_near()) return out;
  DDSSEC_ASSIGN_OR_RETURN(const auto places, participant_places(ca, log));
  for (const auto& folder : places.here) out.add_file(pki::participant_folder(folder).certificate);
  return out;
}

}  // namespace

Status check_list_date(WallTime date, const CaPaths& ca, const Arguments& arguments) {
  if (arguments.has(kClockIsRight.name)) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto known, latest_known(date, ca));
  if (known.is_near()) return {};
  return fail(
      Code::crl_not_yet_valid,
      {.document = ca.crl,
       .expected = fmt::format("a date at most {} days after {}, the latest that the CA's "
                               "certificate, log, list and files know",
                               kMaxRest.count(), to_string(known.time())),
       .found = to_string(date),
       .note = "a list that is dated in the future cannot be used, and it keeps later lists from "
               "being used; nothing was changed",
       .hint = "check the clock of this machine (date, timedatectl); if the date is right, give "
               "--clock-is-right"});
}

}  // namespace ddssec::cli
