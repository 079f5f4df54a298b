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
/// before the file is read for the first time, so that no change is missed. A change of metadata
/// only means that the content may differ: compare the new content with the old one. Not
/// thread-safe.
class FileWatch {
 public:
  /// `uri` is as in base/uri_source.hpp. A relative path is relative to the current working
  /// directory of this moment. No change is ever reported if `uri` names no file, or if `interval`
  /// is 0.
  FileWatch(std::string_view uri, std::chrono::nanoseconds interval);

  /// True if the file must be read now, because it may have been changed, replaced, created or
  /// deleted. Queries the file system at most once per interval, less an eighth of it or 100 ms,
  /// whichever is shorter. `now` is Clock::monotonic.
  bool may_have_changed(std::chrono::nanoseconds now);

  /// The device and the inode of a file. A file that is renamed into place has others than the one
  /// before; a file that is written in place keeps them.
  using FileId = std::array<std::uint64_t, 2>;
  /// Returns that of the file at the last query; empty if there was no file.
  std::optional<FileId> file_id() const {
    return last_ ? std::optional(FileId{(*last_)[0], (*last_)[1]}) : std::nullopt;
  }

  /// Returns the URI by which the file is read, now and later: the result of absolute_uri.
  const std::string& uri() const { return uri_; }

  /// Makes the next query report a change. Call it if the content could not be used.
  void force_change() { is_settled_ = false; }

  /// Makes the next query report a change without waiting for the interval.
  void force_poll() {
    last_query_.reset();
    is_settled_ = false;
  }

 private:
  // A host that asks once per interval is not exactly on time. If one question was late and the
  // next one is not, they are less than an interval apart. Without this slack, the second one would
  // be skipped.
  static constexpr std::chrono::nanoseconds kMaxSlack = std::chrono::milliseconds(100);

  /// Device, inode, size, and seconds and nanoseconds of the last change to the content and to the
  /// inode.
  using Stamp = std::array<std::uint64_t, 7>;
  std::optional<Stamp> stamp() const;

  std::string uri_;
  std::string path_;  ///< empty if the URI names no file
  std::chrono::nanoseconds interval_;
  std::optional<Stamp> last_;
  /// If false, the next query reports a change. File times are coarse, so a change just after the
  /// last query may not be visible.
  bool is_settled_ = false;
  std::optional<std::chrono::nanoseconds> last_query_;
};

}  // namespace ddssec
