// Detects that a file may have changed since it was read, so that it is read again only then.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace ddssec {

/// Compares a file's metadata (device, inode, size, times), following links. Create the watch
/// before the file is read for the first time: then no change is missed. A change of metadata means
/// only that the content may differ: compare it with what you had. Not thread-safe.
class FileWatch {
 public:
  /// `uri` as in base/source.hpp; a relative path is taken relative to the working directory of
  /// now. No change is ever reported if it names no file, or if `interval` is 0.
  FileWatch(std::string_view uri, std::chrono::nanoseconds interval);

  /// True: read the file now; it may have been changed, replaced, created or deleted. Queries the
  /// file system at most once per interval. `now`: Clock::monotonic.
  bool may_have_changed(std::chrono::nanoseconds now);

  /// What to read the file by, now and later: as absolute_uri.
  const std::string& uri() const { return uri_; }

  /// Call it if the content could not be used: the next query then reports a change in any case.
  void force_change() { is_settled_ = false; }

  /// The next query does not wait for the interval, and reports a change in any case.
  void force_poll() {
    looked_.reset();
    is_settled_ = false;
  }

 private:
  /// Device, inode, size, and seconds and nanoseconds of the last change to the content and to the
  /// inode.
  using Stamp = std::array<std::uint64_t, 7>;
  std::optional<Stamp> stamp() const;

  std::string uri_;
  std::string path_;  ///< empty: the URI names no file
  std::chrono::nanoseconds interval_;
  std::optional<Stamp> last_;
  /// False: report a change at the next query. File times are coarse, so a change just after the
  /// last query may not be visible.
  bool is_settled_ = false;
  std::optional<std::chrono::nanoseconds> looked_;
};

}  // namespace ddssec
