// Tells when a file that was read may have changed, so that it is read again only then.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace ddssec {

/// Compares what the file system says of a file (which one it is, its size, its times), links
/// followed. Make it before the file is read for the first time: then no change is missed. It says
/// "maybe": compare what you read with what you had. Not thread-safe.
class FileWatch {
 public:
  /// `uri` as in base/source.hpp. Nothing changes if it names no file, or with an `interval` of 0.
  FileWatch(std::string_view uri, std::chrono::nanoseconds interval);

  /// True: read it now, it was changed, replaced, put there or taken away. Asks the file system at
  /// most once an interval. `now`: Clock::monotonic.
  bool may_have_changed(std::chrono::nanoseconds now);

  /// What was read could not be used: the next look finds a change in any case.
  void look_again() { is_settled_ = false; }

 private:
  /// Device, inode, size, seconds and nanoseconds of the last change to the content and to the
  /// inode.
  using Stamp = std::array<std::uint64_t, 7>;
  std::optional<Stamp> stamp() const;

  std::string path_;  ///< empty: there is no file
  std::chrono::nanoseconds interval_;
  std::optional<Stamp> last_;
  /// False: times of files are coarse, so a change just after the last look may have left no trace.
  bool is_settled_ = false;
  std::optional<std::chrono::nanoseconds> looked_;
};

}  // namespace ddssec
