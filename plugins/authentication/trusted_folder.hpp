// The folder of trusted identity CAs, whose files may change while the participant runs.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/file_watch.hpp"
#include "base/renewal_refusals.hpp"
#include "pki/certificate.hpp"
#include "pki/withdrawn_authorities.hpp"

namespace ddssec::authentication {

/// Reads the CAs of a trusted_ca_dir, and adopts others that its files contain later. Files without
/// a CA are skipped. Not thread-safe.
class TrustedFolder {
 public:
  /// The largest number of CAs, as in Cyclone DDS.
  static constexpr std::size_t kMaxAuthorities = 100;
  /// The largest number of files, which are looked at once per interval.
  static constexpr std::size_t kMaxFiles = 1000;

  using Authorities = std::vector<pki::Certificate>;

  /// `value` is the property's: a path or a file URI. A relative path is relative to the current
  /// working directory of this moment. With an interval of 0, changes are not looked for.
  TrustedFolder(std::string_view value, std::chrono::seconds interval);

  /// Reads the folder when the participant starts. Errors: trusted_ca_dir_unreadable,
  /// trusted_ca_dir_too_many.
  Result<Authorities> read_first();

  /// Judges CAs that would replace those in force, and uses them if they are good.
  using Adopt = std::function<Status(const Authorities&)>;
  /// Reads the folder again if it may have changed. Returns true if other CAs are in force. A
  /// folder that lacks a CA in force counts at the second poll in a row that reads the same. `now`
  /// is Clock::monotonic. Error: identity_ca_renewal_refused or folder_unreadable, once as long as
  /// the content stays the same. The reasons are those of read_first and `adopt`, ca_put_back, and
  /// that a file with a CA in force cannot be read any more.
  Result<bool> poll(std::chrono::nanoseconds now, const Authorities& in_force, const Adopt& adopt);

  /// Makes the next poll read the folder without waiting for the interval.
  void force_poll() { folder_.force_poll(); }

  /// Returns the last error of poll(), or nothing if the folder has been good since.
  const std::optional<Error>& refused() const { return refusals_.refused(); }
  /// Returns the state of the folder.
  FileState state() const { return refusals_.state(); }
  /// Returns the absolute path of the folder.
  const std::string& path() const { return path_; }

 private:
  /// The CAs of each file that has any, by its path.
  using Contents = std::map<std::string, Authorities>;

  bool may_have_changed(std::chrono::nanoseconds now);
  Result<std::vector<std::string>> list_files() const;
  Result<Contents> read();
  Status check_sources(const Contents& contents) const;
  Result<bool> adopt_if_other(const Contents& contents, const Authorities& in_force,
                              const Adopt& adopt);

  std::string path_;
  std::chrono::nanoseconds interval_;
  FileWatch folder_;
  std::map<std::string, FileWatch> files_;
  std::vector<std::string> sources_;  ///< the files that had the CAs in force
  pki::WithdrawnAuthorities withdrawn_;
  RenewalRefusals refusals_;
  std::optional<Sha256Digest> last_read_;  ///< digest of what the last poll read
  bool is_as_at_last_poll_ = false;
};

}  // namespace ddssec::authentication
