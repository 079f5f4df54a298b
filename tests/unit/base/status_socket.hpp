// A folder for the status socket of this process, and clients of it.
#pragma once

#include <poll.h>
#include <string>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "base/file_descriptor.hpp"
#include "base/status_server.hpp"
#include "tests/support/temporary_folder.hpp"

namespace ddssec {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

inline sockaddr_un address_of(const std::string& path) {
  sockaddr_un out{};
  out.sun_family = AF_UNIX;
  path.copy(out.sun_path, sizeof out.sun_path - 1);
  return out;
}

inline FileDescriptor connected(const std::string& path) {
  FileDescriptor out(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const auto address = address_of(path);
  const auto* const generic = reinterpret_cast<const sockaddr*>(&address);
  if (::connect(out.number(), generic, sizeof address) != 0) return FileDescriptor();
  return out;
}

/// Returns what is read within the time; empty if nothing comes.
inline std::string read_all(const FileDescriptor& socket, std::chrono::milliseconds within = 30s) {
  std::string out;
  char piece[4096];
  while (true) {
    pollfd polled{socket.number(), POLLIN, 0};
    if (::poll(&polled, 1, static_cast<int>(within.count())) != 1) return {};
    const auto count = ::read(socket.number(), piece, sizeof piece);
    if (count <= 0) return out;
    out.append(piece, static_cast<std::size_t>(count));
  }
}

inline std::string answer_at(const std::string& path) { return read_all(connected(path)); }

class Server : public testing::Test {
 protected:
  Result<std::unique_ptr<StatusServer>> start(StatusServer::Answer answer = [] {
    return std::string("hello");
  }) const {
    return StatusServer::start(folder_.path(), std::move(answer));
  }
  std::string path(const std::string& more = "") const {
    return folder_.path() + "/ddssec-" + std::to_string(pid_) + more + ".sock";
  }
  bool has_sockets() const { return !fs::is_empty(folder_.path()); }
  /// Returns the result of `f` in a child process.
  template <class F>
  static int in_child(F&& f) {
    const auto child = ::fork();
    if (child == 0) ::_exit(f() ? 0 : 1);
    int status = -1;
    ::waitpid(child, &status, 0);
    return status;
  }
  template <class F>
  static int as_another_user(F&& f) {
    return in_child([&] { return ::setgid(65534) == 0 && ::setuid(65534) == 0 && f(); });
  }

  const pid_t pid_ = ::getpid();
  const test::TemporaryFolder folder_;
};

}  // namespace ddssec
