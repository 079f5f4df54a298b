// When to report that a file with a renewed document cannot be used, and what to say.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/hash.hpp"
#include "base/result.hpp"

namespace ddssec {

/// A file is reported if it was wrong at two polls in a row, so not if it is just being written;
/// and once, as long as it stays the same. Not thread-safe.
class RenewalRefusals {
 public:
  /// The file was wrong at this poll. True: report it. `content`: of what could be read.
  bool is_due(Code why, const Sha256Digest& content) {
    const bool is_lasting = std::exchange(was_refused_, true);
    if (!is_lasting || told_ == std::pair{why, content}) return false;
    told_ = {why, content};
    return true;
  }
  /// The report of the refusal that is due, for refused().
  Error note(Error report) {
    refused_ = std::move(report);
    return *refused_;
  }
  /// The file was good.
  void clear() {
    was_refused_ = false;
    told_.reset();
    refused_.reset();
  }
  /// The last report, while the file has not been good since.
  const std::optional<Error>& refused() const { return refused_; }
  /// True if that was refused only because it begins in the future: it is taken when it begins.
  bool begins_later() const {
    return refused_ && told_ &&
           (told_->first == Code::certificate_not_yet_valid ||
            told_->first == Code::grant_not_yet_valid || told_->first == Code::ocsp_not_yet_valid);
  }

 private:
  bool was_refused_ = false;  ///< at the last poll
  std::optional<std::pair<Code, Sha256Digest>> told_;
  std::optional<Error> refused_;
};

/// folder_unreadable, which is the same for all files in the folder, if `why` is that the file
/// cannot be read because the process cannot enter its folder; else nothing.
std::optional<Error> folder_refused(const Error& why, const std::string& path);

/// The event about a file that stays refused: `code`, with what `why` says; or folder_refused.
/// `stays`: the document that is still in force.
Error renewal_refused(Code code, const Error& why, const std::string& path, std::string_view stays);

}  // namespace ddssec
