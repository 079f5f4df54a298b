// Decides when to report that a file with a renewed document cannot be used, and what the report
// says.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "base/hash.hpp"
#include "base/result.hpp"

namespace ddssec {

/// What the present content of a document's file is. Of several files, the largest value counts.
enum class FileState : std::uint8_t {
  current,    ///< it is in force, or there is no file yet
  candidate,  ///< it is not in force yet: it is judged again, begins later or waits for peers
  refused     ///< it is not taken
};
/// Returns "current", "candidate" or "refused".
std::string_view to_string(FileState state);

/// The state of one file. It is reported only if it was wrong at two polls in a row, because it may
/// just be being written, and once as long as it stays the same. Edges: current or candidate ->
/// candidate (wrong once, or undecided), candidate -> refused (wrong again), any -> current (good).
/// Not thread-safe.
class RenewalRefusals {
 public:
  /// Notes that the file was wrong at this poll. Returns true if that must be reported. `content`
  /// is the digest of the octets that could be read.
  bool note_refusal(Code why, const Sha256Digest& content) {
    const bool is_lasting = std::exchange(was_refused_, true);
    if (!is_lasting) return false;
    const bool is_new = last_reported_ != std::pair{why, content};
    if (!std::exchange(reports_again_, false) && !is_new) return false;
    last_reported_ = {why, content};
    return true;
  }
  /// Lets the next refusal be reported even if it is the same as the last one.
  void report_again() { reports_again_ = true; }
  /// Notes that this poll does not decide on the file. A refusal at the next poll is then the
  /// second in a row.
  void note_doubt() { was_refused_ = true; }
  /// Keeps the report of the refusal, for refused(), and returns it.
  Error note(Error report) {
    refused_ = std::move(report);
    return *refused_;
  }
  /// Notes that the file was good.
  void clear() { *this = RenewalRefusals(); }
  /// Returns the last report, or nothing if the file has been good since.
  const std::optional<Error>& refused() const { return refused_; }
  FileState state() const {
    if (!was_refused_) return FileState::current;
    return refused_ && !begins_later() ? FileState::refused : FileState::candidate;
  }

 private:
  // The document was refused only because it begins in the future. It is adopted when it begins.
  bool begins_later() const {
    constexpr std::array kReasons = {Code::certificate_not_yet_valid, Code::crl_not_yet_valid,
                                     Code::grant_not_yet_valid, Code::ocsp_not_yet_valid};
    return last_reported_ && std::ranges::find(kReasons, last_reported_->first) != kReasons.end();
  }

  bool was_refused_ = false;  ///< the file was wrong at the last poll
  bool reports_again_ = false;
  std::optional<std::pair<Code, Sha256Digest>> last_reported_;
  std::optional<Error> refused_;
};

/// Returns folder_unreadable if `why` says that the file cannot be read, and the reason is that the
/// process cannot enter its folder. This error is the same for all files of the folder. Otherwise
/// returns nothing.
std::optional<Error> folder_refused(const Error& why, const std::string& path);

/// Makes the event about a file that stays refused: folder_refused if that applies, otherwise
/// `code` with the details of `why`. `stays` names the document that is still in force.
Error renewal_refused_error(Code code, const Error& why, const std::string& path,
                            std::string_view stays);

}  // namespace ddssec
