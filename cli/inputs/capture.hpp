// Reads frames from a network interface or from a file of tcpdump or Wireshark, with libpcap.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "cli/frame/report.hpp"

namespace ddssec::cli {

/// One frame. `octets` are valid until the next frame is read.
struct CapturedFrame {
  std::chrono::nanoseconds at;  ///< since 1970
  BytesView octets;
  bool is_whole;  ///< false: the capture cut it
};

/// A source of frames: a network interface, or a file that tcpdump wrote.
class Capture {
 public:
  /// Opens a pcap or pcapng file; "-" is standard input. Error: capture_unreadable (also if libpcap
  /// is missing).
  static Result<Capture> open(const std::string& file);
  /// Captures from an interface from now on. Error: capture_unreadable.
  static Result<Capture> listen(const std::string& interface);
  ~Capture();
  Capture(Capture&&) noexcept;

  /// Returns the link type, as LINKTYPE_ of libpcap.
  int link() const;
  /// Opens a new pcap file, which only its owner can read, and writes each frame to it that is read
  /// from now on. A dry run only checks that the file can be created. Errors: would_overwrite,
  /// file_unwritable.
  Status save_to(const std::string& file);
  /// Closes the file of save_to() and returns its path and hash. If it cannot be written
  /// completely, it is removed. Error: file_unwritable.
  Result<WrittenFile> saved();
  /// Passes frames to `take` until the end of the file, for `how_long` when listening, or until
  /// interrupted. Error: capture_unreadable.
  Status each(std::chrono::nanoseconds how_long,
              const std::function<void(const CapturedFrame&)>& take);

 private:
  struct Impl;
  explicit Capture(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ddssec::cli
