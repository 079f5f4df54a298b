// Asks running processes which documents they use (base/status_server.hpp).
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <sys/types.h>
#include <vector>

#include "base/descriptor.hpp"
#include "cli/frame/report.hpp"

namespace ddssec::cli {

/// The sockets of a folder that DDSSEC_STATUS_DIR names.
class StatusFolder {
 public:
  struct Socket {
    pid_t pid;
    std::string name;
  };

  /// Errors: file_not_found, file_unreadable, status_of_another_user (it may not be entered),
  /// status_folder_untrusted, link_untrusted.
  static Result<StatusFolder> open(const std::filesystem::path& path);

  static constexpr std::size_t kMostSockets = 1024;

  /// ddssec-PID.sock and ddssec-PID-2.sock to -8.sock, in order; at most kMostSockets.
  const std::vector<Socket>& sockets() const { return sockets_; }
  /// The number of sockets that the folder has besides.
  std::size_t left_out() const { return left_out_; }
  const std::filesystem::path& path() const { return path_; }

  struct Answer {
    /// Each with `identity`, `guid`, `subject`, `cut_off` and `documents`.
    Json participants;
    std::uint64_t left_out = 0;  ///< number of participants that the answer had no room for
  };
  /// The participants of the process. Only an answer of the folder's owner, of this user or of root
  /// counts. It is bounded in size, and all answers of the folder together in size and time.
  /// Errors: status_process_ended, status_of_another_user, status_unanswered.
  Result<Answer> ask(const Socket& socket);

 private:
  StatusFolder(std::filesystem::path path, Descriptor folder, uid_t owner);
  void list();
  std::unexpected<Error> cannot(const Socket& socket, Code code, std::string note) const;
  Result<Descriptor> connect(const Socket& socket) const;
  Status check_answering(const Socket& socket, int connection) const;
  Result<std::string> read_all(const Socket& socket, int connection);

  std::filesystem::path path_;
  Descriptor folder_;
  uid_t owner_;
  std::vector<Socket> sockets_;
  std::size_t left_out_ = 0;
  std::size_t octets_left_;
  std::chrono::steady_clock::time_point until_{};  ///< no answer counts later
};

/// True if a process has this number.
bool is_running(pid_t pid);

}  // namespace ddssec::cli
