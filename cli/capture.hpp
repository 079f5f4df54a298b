// Frames of a network interface or of a file that tcpdump or Wireshark wrote, by libpcap.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "cli/report.hpp"

namespace ddssec::cli {

/// One frame. `octets` are there until the next one is read.
struct Frame {
  std::chrono::nanoseconds at;  ///< since 1970
  BytesView octets;
  bool is_whole;  ///< false: the capture cut it
};

class Capture {
 public:
  /// A pcap or pcapng file; "-": standard input. Error: capture_unreadable.
  static Result<Capture> open(const std::string& file);
  /// What passes an interface from now on. Error: capture_unreadable.
  static Result<Capture> listen(const std::string& interface);
  ~Capture();
  Capture(Capture&&) noexcept;

  /// LINKTYPE_ of libpcap.
  int link() const;
  /// From here on writes every frame that is read to a new pcap file, for its owner only; in a dry
  /// run only sees whether there is room for one. Errors: would_overwrite, file_unwritable.
  Status save_to(const std::string& file);
  /// Ends that file. Error: file_unwritable; then it is removed.
  Result<WrittenFile> saved();
  /// Hands over frames until the end of the file, or for so long when listening, or until
  /// interrupted. Error: capture_unreadable.
  Status each(std::chrono::nanoseconds how_long, const std::function<void(const Frame&)>& take);

 private:
  struct Impl;
  explicit Capture(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ddssec::cli
