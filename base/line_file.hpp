// An output for lines that never blocks.
#pragma once

#include <atomic>
#include <string>
#include <string_view>

namespace ddssec {

/// An output for lines: a regular file, a FIFO with a reader, a terminal or another character
/// device. Neither opening nor writing ever blocks. Thread-safe.
class LineFile {
 public:
  /// Opens `path`; creates a regular file if it does not exist. See is_open().
  explicit LineFile(const char* path);
  ~LineFile();
  LineFile(const LineFile&) = delete;
  LineFile& operator=(const LineFile&) = delete;

  /// False if the path is no such output or cannot be written, for example a FIFO without a reader.
  bool is_open() const { return file_ >= 0; }
  /// Returns the reason why the file could not be opened: either the kind of file that is at the
  /// path, or the error of the system.
  const std::string& why_not() const { return why_not_; }

  /// Appends a line and its end in one write, so that several processes may share a file. The line
  /// is dropped if writing would block, if the reader has left, or if the disk is full. Returns
  /// false if the line was dropped or cut. After a cut line the next one begins with an end of
  /// line.
  bool append(std::string_view line);

 private:
  int file_;
  std::string why_not_;
  std::atomic<bool> is_torn_ = false;  ///< the last line is incomplete
};

}  // namespace ddssec
