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

/// No file need exist. The entries of all files count together. Not thread-safe.
class RenewalListWatch {
 public:
  /// `uris` of files. `refused`: the code of events about a file that cannot be used.
  RenewalListWatch(const std::vector<std::string>& uris, std::chrono::seconds interval,
                   Code refused);

  /// Judges entries that would take the place of those in force, and uses them if they are good.
  using Adopt = std::function<Status(const RenewalList&)>;
  /// Reads each file that may have changed. True: other entries are in force. Error: the fault of a
  /// file that was wrong at two looks in a row, once as long as the file stays the same; the
  /// entries in force stay. A file that disappears after it was read is wrong. `now`:
  /// Clock::monotonic.
  Result<bool> poll(std::chrono::nanoseconds now, const Adopt& adopt);

  /// The next poll reads the files, whatever the interval is.
  void force_poll();
  /// The same, and judges their entries as if they were new: what they are judged by has changed.
  void judge_again();

  /// The file whose entries were taken last, or else the first one; empty if there is none.
  std::string path() const;
  /// The last error of poll() about a file that has not been good since.
  std::optional<Error> refused() const;

 private:
  struct Place {
    FileWatch watch;
    std::string path;
    std::optional<Sha256Digest> content = {};  ///< of the file whose entries are in force
    RenewalList list = {};
    RenewalRefusals refusals = {};
  };

  Result<bool> look_at(Place& place, const Adopt& adopt);
  Status judge(Place& place, BytesView file, const Adopt& adopt);
  RenewalList together() const;

  const Code refused_;
  std::vector<Place> places_;
  std::size_t taken_from_ = 0;
};

}  // namespace ddssec::pki
