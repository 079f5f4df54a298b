// The file that DDSSEC_EVENT_LOG names.
#pragma once

#include <atomic>
#include <string_view>

namespace ddssec::cyclonedds {

/// A place for lines: a regular file, a FIFO with a reader, a terminal or another character device.
/// Neither opening nor writing ever waits. Thread-safe.
class EventFile {
 public:
  /// Makes a regular file if nothing is there; see is_open().
  explicit EventFile(const char* path);
  ~EventFile();
  EventFile(const EventFile&) = delete;
  EventFile& operator=(const EventFile&) = delete;

  /// False for what is no such place or cannot be written, such as a FIFO without a reader.
  bool is_open() const { return file_ >= 0; }

  /// Appends a line and its end, in one write, so that several processes may share a file. A line
  /// that would have to wait is dropped, and so is one for a reader that left, or for which the
  /// disk has no room. False: dropped, or cut; the next line then begins with an end of line.
  bool append(std::string_view line);

 private:
  int file_;
  std::atomic<bool> is_torn_ = false;  ///< the last line has no end yet
};

}  // namespace ddssec::cyclonedds
