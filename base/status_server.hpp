// A Unix domain socket that gives each client of the same user one text.
#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <sys/types.h>
#include <thread>

#include "base/file_descriptor.hpp"
#include "base/result.hpp"

namespace ddssec {

/// Answers clients in a background thread, so that only this thread waits for them. Each client
/// gets the text of that moment, and its connection is closed. What clients send is not read. Only
/// root and the user of the process get an answer (SO_PEERCRED). There are at most kMaxClients
/// connections, and kMaxPerSecond new ones in a second; further ones wait. In the child of a fork()
/// nothing is served.
class StatusServer {
 public:
  static constexpr std::size_t kMaxClients = 8;
  static constexpr unsigned kMaxPerSecond = 32;
  /// How long a client may take to receive the whole answer. After that it is dropped.
  static constexpr std::chrono::seconds kClientTimeout{5};
  /// The largest number of libraries in one process that serve, each with its own socket.
  static constexpr int kMaxOfAProcess = 8;

  /// Makes the text. Called in the thread; must be thread-safe, and valid until the server is
  /// destroyed.
  using Answer = std::function<std::string()>;
  /// Makes ddssec-PID.sock with mode 0600 in `folder`, or ddssec-PID-2.sock and so on if another
  /// library of the process uses that name. The folder must be given by an absolute path, belong to
  /// this user or root, and be writable for no other user; links in the path are followed as
  /// open_guarded does. A socket of this name that no process serves is replaced. Error:
  /// status_not_served.
  static Result<std::unique_ptr<StatusServer>> start(const std::string& folder, Answer answer);
  /// Ends the thread and removes the socket. Does neither in the child of a fork().
  ~StatusServer();
  StatusServer(const StatusServer&) = delete;
  StatusServer& operator=(const StatusServer&) = delete;

  /// Removes the socket only, for the exit of a process whose participants live on.
  void remove_socket() noexcept;

 private:
  using Time = std::chrono::steady_clock::time_point;
  struct Client {
    FileDescriptor socket = FileDescriptor();
    std::string text = {};
    std::size_t sent = 0;
    Time until = {};
  };

  StatusServer(std::string folder_name, FileDescriptor folder, Answer answer);
  std::unexpected<Error> not_served_error(std::string expected, std::string found) const;
  Status check_folder() const;
  Status listen();
  Status bind_first_free();
  Status bind_to(const std::string& name);
  bool probe_abandoned(const std::string& name) const;
  std::string path_of(const std::string& name) const;
  Status start_thread();

  void serve() noexcept;
  bool serve_once();
  bool wait_to_recover();
  bool has_room() const;
  void accept_one();
  bool is_allowed(int client) const;
  void send_to(Client& client);
  int milliseconds_to_wait() const;

  const std::string folder_name_;
  const FileDescriptor folder_;
  const Answer answer_;
  const pid_t pid_;
  const uid_t user_;
  std::string name_;  ///< name of the socket in the folder; empty if there is none
  FileDescriptor socket_;
  FileDescriptor stop_;  ///< an eventfd
  std::array<Client, kMaxClients> clients_;
  Time second_ = {};  ///< the start of the second in which `accepted_` counts
  unsigned accepted_ = 0;
  std::optional<Time> paused_until_;  ///< no connection is accepted before this time
  std::unique_ptr<std::thread> thread_;
};

}  // namespace ddssec
