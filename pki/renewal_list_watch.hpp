// The files of a participant that may hold a renewal list.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/file_watch.hpp"
#include "base/renewal_refusals.hpp"
#include "pki/renewal_list.hpp"

namespace ddssec::pki {

/// Watches these files, none of which need exist, and adopts the entries of all of them together. A
/// file that lacks an entry in force may just be being written. The entry then stays in force until
/// the second poll in a row that reads the same; new entries count at once. Not thread-safe.
class RenewalListWatch {
 public:
  /// `uris` are those of the files. `refused` is the code of events about a file that cannot be
  /// used.
  RenewalListWatch(const std::vector<std::string>& uris, std::chrono::seconds interval,
                   Code refused);

  /// Judges entries that would replace those in force, and uses them if they are good.
  using Adopt = std::function<Status(const RenewalList&)>;
  /// Reads each file that may have changed. Returns true if exactly the entries of the files are in
  /// force, and others were before. `now` is Clock::monotonic. Error: the fault of a file that was
  /// wrong at two polls in a row, once as long as the file stays the same; the entries in force
  /// stay. A file that disappears after it was read counts as wrong.
  Result<bool> poll(std::chrono::nanoseconds now, const Adopt& adopt);

  /// Makes the next poll read the files without waiting for the interval.
  void force_poll();
  /// Also makes the next poll judge the entries as if they were new. Call it if the CAs or other
  /// facts by which they are judged have changed.
  void reevaluate();

  /// Returns the file whose entries were adopted last, or else the first one; empty if there is
  /// none.
  std::string path() const;
  /// Returns the last error of poll() about a file that has not been good since.
  std::optional<Error> refused() const;
  /// Returns the state of the files.
  FileState state() const;

 private:
  struct Place {
    FileWatch watch;
    std::string path;
    std::optional<Sha256Digest> content = {};  ///< digest of the file whose entries are in force
    /// Digest of what the last poll read.
    std::optional<Sha256Digest> last_read = {};
    RenewalList list = {};
    RenewalRefusals refusals = {};
  };

  Result<bool> read_place(Place& place, const Adopt& adopt);
  Result<bool> adopt_list(Place& place, BytesView file, bool is_second_look, const Adopt& adopt);
  RenewalList merged_list() const;

  const Code refused_;
  std::vector<Place> places_;
  std::size_t taken_from_ = 0;
};

}  // namespace ddssec::pki
