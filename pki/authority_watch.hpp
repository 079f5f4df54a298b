// A CA file of a local participant, which may be replaced while the participant runs.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/document_watch.hpp"
#include "pki/withdrawn_authorities.hpp"

namespace ddssec::pki {

/// Watches one CA file, and adopts CAs that replace those in force. A file that lacks a CA in force
/// counts at the second poll in a row that reads the same, because it may just be being written.
/// Not thread-safe.
class AuthorityWatch {
 public:
  /// If a file that is written in place lacked a CA, and goes on with it within this time, the CA
  /// may come back (WithdrawnAuthorities). A file that is renamed into place has no such time.
  static constexpr std::chrono::seconds kMaxWritingTime{30};

  /// Create the watch before the file is read for the first time. It sets `what.max_octets` itself.
  AuthorityWatch(DocumentWatch::WatchedDocument what, std::chrono::seconds interval);

  using Authorities = std::vector<Certificate>;
  /// Judges CAs that would replace those in force, and uses them if they are good.
  using Adopt = std::function<Status(const Authorities&)>;
  /// Reads the file if it may have changed. Returns true if other CAs are in force. A file with the
  /// same CAs in another order counts as the same. `in_force` must not change while `adopt` runs.
  /// Errors are reported as by DocumentWatch::poll: the fault of the file, the refusal of `adopt`,
  /// or ca_put_back.
  Result<bool> poll(std::chrono::nanoseconds now, const Authorities& in_force, const Adopt& adopt);

  /// Makes the next poll read the file without waiting for the interval.
  void force_poll() { file_.force_poll(); }

  /// Returns the last error of poll(), or nothing if the file has been good since.
  const std::optional<Error>& refused() const { return file_.refused(); }
  /// Returns the state of the file.
  FileState state() const { return file_.state(); }

  /// Returns the path of the file, or the name of the property if the CAs are not in a file.
  const std::string& name() const { return file_.name(); }

 private:
  /// A file that was adopted with fewer CAs, and may have been written in place.
  struct Cut {
    Sha256Digest content;
    std::size_t octets;
    std::chrono::nanoseconds at;  ///< when it first lacked one
    Authorities left;             ///< the CAs that it lacks
  };

  struct FileOfNext {
    BytesView octets;
    const Authorities& next;  ///< the CAs in the file
    std::chrono::nanoseconds now;
  };

  Status adopt_next(const FileOfNext& file, const Authorities& in_force, const Adopt& adopt);
  bool continues_cut_file(BytesView file, std::chrono::nanoseconds now) const;

  DocumentWatch file_;
  WithdrawnAuthorities withdrawn_;
  std::optional<FileWatch::FileId> file_in_force_;  ///< the file that had the CAs in force
  std::optional<Cut> cut_;
};

}  // namespace ddssec::pki
