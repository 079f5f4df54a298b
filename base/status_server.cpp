#include "base/status_server.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/background_thread.hpp"
#include "base/errno_text.hpp"
#include "base/guarded_path.hpp"

namespace ddssec {
namespace {

using std::chrono::steady_clock;

constexpr int kBacklog = 16;
constexpr std::chrono::seconds kSecond{1};
constexpr std::chrono::milliseconds kRecoveryStep{50};

FileDescriptor unix_socket() {
  return FileDescriptor(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

sockaddr_un address_of(const std::string& path) {
  sockaddr_un out{};
  out.sun_family = AF_UNIX;
  std::memcpy(out.sun_path, path.data(), std::min(path.size(), sizeof out.sun_path - 1));
  return out;
}

const sockaddr* generic(const sockaddr_un& address) {
  return static_cast<const sockaddr*>(static_cast<const void*>(&address));
}

}  // namespace

Result<std::unique_ptr<StatusServer>> StatusServer::start(const std::string& folder,
                                                          Answer answer) {
  const auto folder_error = [&](std::string expected, std::string found) {
    return fail(Code::status_not_served,
                {.document = folder, .expected = std::move(expected), .found = std::move(found)});
  };
  if (!folder.starts_with('/')) return folder_error("an absolute path", "a relative one");
  auto opened = open_guarded(folder, O_PATH);
  if (!opened)
    return folder_error("links in the path that only root and this user can change",
                        opened.error().message());
  if (!*opened) return folder_error("a folder", errno_text(errno));
  std::unique_ptr<StatusServer> out(
      new StatusServer(folder, *std::move(opened), std::move(answer)));
  DDSSEC_RETURN_IF_ERROR(out->check_folder());
  DDSSEC_RETURN_IF_ERROR(out->listen());
  DDSSEC_RETURN_IF_ERROR(out->start_thread());
  return out;
}

StatusServer::StatusServer(std::string folder_name, FileDescriptor folder, Answer answer)
    : folder_name_(std::move(folder_name)),
      folder_(std::move(folder)),
      answer_(std::move(answer)),
      pid_(::getpid()),
      user_(::geteuid()),
      stop_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

StatusServer::~StatusServer() {
  if (::getpid() != pid_) {
    // The thread exists only in the parent, so joining it would never end.
    static_cast<void>(thread_.release());
    return;
  }
  if (thread_) {
    ::eventfd_write(stop_.number(), 1);
    thread_->join();
  }
  remove_socket();
}

void StatusServer::remove_socket() noexcept {
  if (name_.empty() || ::getpid() != pid_) return;
  ::unlinkat(folder_.number(), name_.c_str(), 0);
  name_.clear();
}

std::unexpected<Error> StatusServer::not_served_error(std::string expected,
                                                      std::string found) const {
  return fail(
      Code::status_not_served,
      {.document = folder_name_, .expected = std::move(expected), .found = std::move(found)});
}

Status StatusServer::check_folder() const {
  struct stat status {};
  if (::fstat(folder_.number(), &status) != 0)
    return not_served_error("a folder", errno_text(errno));
  const bool is_ours = status.st_uid == user_ || status.st_uid == 0;
  if (is_ours && (status.st_mode & 022) == 0) return {};
  return not_served_error(
      fmt::format("a folder of user {} or root that no other user can write to", user_),
      fmt::format("user {}, mode {:04o}", status.st_uid, status.st_mode & 07777));
}

// ---- functions that make and bind the socket

// The path goes through the open folder's descriptor: it always fits into a sockaddr_un, and the
// folder cannot be exchanged for another one.
std::string StatusServer::path_of(const std::string& name) const {
  return fmt::format("/proc/self/fd/{}/{}", folder_.number(), name);
}

Status StatusServer::listen() {
  DDSSEC_RETURN_IF_ERROR(bind_first_free());
  if (stop_ && ::listen(socket_.number(), kBacklog) == 0) return {};
  return not_served_error("a socket", errno_text(errno));
}

Status StatusServer::bind_first_free() {
  Status status;
  for (int i = 1; i <= kMaxOfAProcess; ++i) {
    const auto name =
        i == 1 ? fmt::format("ddssec-{}.sock", pid_) : fmt::format("ddssec-{}-{}.sock", pid_, i);
    status = bind_to(name);
    if (status || errno != EADDRINUSE) return status;
  }
  return status;
}

// On error, errno keeps the reason: bind_first_free() reads it to try the next name.
Status StatusServer::bind_to(const std::string& name) {
  socket_ = unix_socket();
  // The mode is set before bind(), so that the socket is never open to others.
  bool is_bound = socket_ && ::fchmod(socket_.number(), 0600) == 0;
  const auto address = address_of(path_of(name));
  const auto bind = [&] { return ::bind(socket_.number(), generic(address), sizeof address) == 0; };
  is_bound = is_bound && (bind() || (errno == EADDRINUSE && probe_abandoned(name) &&
                                     ::unlinkat(folder_.number(), name.c_str(), 0) == 0 && bind()));
  if (is_bound) {
    name_ = name;
    return {};
  }
  const int error = errno;
  auto refused = not_served_error("room for the socket " + name, errno_text(error));
  errno = error;
  return refused;
}

// Connects to the socket. Returns true if no process listens on it: a killed process with the same
// process number left it. Sets errno to EADDRINUSE.
bool StatusServer::probe_abandoned(const std::string& name) const {
  struct stat status {};
  const bool is_socket =
      ::fstatat(folder_.number(), name.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0 &&
      S_ISSOCK(status.st_mode);
  const auto probe = unix_socket();
  const auto address = address_of(path_of(name));
  const bool is_refused = is_socket && probe &&
                          ::connect(probe.number(), generic(address), sizeof address) != 0 &&
                          errno == ECONNREFUSED;
  errno = EADDRINUSE;
  return is_refused;
}

Status StatusServer::start_thread() {
  try {
    thread_ =
        std::make_unique<std::thread>(start_background_thread<std::thread>([this] { serve(); }));
    return {};
  } catch (const std::exception& error) {
    return not_served_error("a thread", error.what());
  }
}

// ---- functions that run in the server's thread

void StatusServer::serve() noexcept {
  while (true) {
    try {
      if (!serve_once()) return;
    } catch (...) {
      // There is no memory for an answer, but the host must not end because of that.
      for (auto& client : clients_) client = Client();
    }
  }
}

bool StatusServer::has_room() const {
  return std::ranges::any_of(clients_, [](const Client& one) { return !one.socket; });
}

int StatusServer::milliseconds_to_wait() const {
  auto until = paused_until_;
  for (const auto& client : clients_)
    if (client.socket && (!until || client.until < *until)) until = client.until;
  if (!until) return -1;
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(*until - steady_clock::now());
  return static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 10'000));
}

// Waits for clients and serves them. Returns false if the server is to stop.
bool StatusServer::serve_once() {
  std::array<pollfd, kMaxClients + 2> polled{};
  const bool accepts = has_room() && !paused_until_;
  polled[0] = {stop_.number(), POLLIN, 0};
  polled[1] = {accepts ? socket_.number() : -1, POLLIN, 0};
  for (std::size_t i = 0; i < kMaxClients; ++i)
    polled[i + 2] = {clients_[i].socket.number(), POLLOUT, 0};
  if (::poll(polled.data(), polled.size(), milliseconds_to_wait()) < 0)
    return errno == EINTR || wait_to_recover();
  if (polled[0].revents != 0) return false;
  const auto now = steady_clock::now();
  if (paused_until_ && now >= *paused_until_) paused_until_.reset();
  for (std::size_t i = 0; i < kMaxClients; ++i) {
    if (polled[i + 2].revents != 0) send_to(clients_[i]);
    if (clients_[i].socket && now >= clients_[i].until) clients_[i] = Client();
  }
  if (polled[1].revents != 0) accept_one();
  return true;
}

// Waits one second after poll() failed: memory may be short, or RLIMIT_NOFILE lower than the number
// of descriptors polled. Returns false if the server is to stop.
bool StatusServer::wait_to_recover() {
  eventfd_t ignored = 0;
  for (auto left = kSecond / kRecoveryStep; left > 0; --left) {
    if (::eventfd_read(stop_.number(), &ignored) == 0) return false;
    std::this_thread::sleep_for(kRecoveryStep);
  }
  return true;
}

void StatusServer::accept_one() {
  const auto now = steady_clock::now();
  FileDescriptor socket(
      ::accept4(socket_.number(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (!socket) {
    // If no descriptor is free, the connection keeps waiting and poll() would report it at once.
    if (errno != EAGAIN && errno != EINTR) paused_until_ = now + kSecond;
    return;
  }
  if (now - second_ >= kSecond) {
    second_ = now;
    accepted_ = 0;
  }
  if (++accepted_ >= kMaxPerSecond) paused_until_ = second_ + kSecond;
  if (!is_allowed(socket.number())) return;
  const auto free = std::ranges::find_if(clients_, [](const Client& one) { return !one.socket; });
  if (free == clients_.end()) return;
  auto text = answer_();
  // On a machine under load the text may have taken seconds, so the client's time starts now.
  *free = Client{std::move(socket), std::move(text), 0, steady_clock::now() + kClientTimeout};
  send_to(*free);
}

bool StatusServer::is_allowed(int client) const {
  ucred peer{};
  socklen_t size = sizeof peer;
  return ::getsockopt(client, SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0 &&
         (peer.uid == user_ || peer.uid == 0);
}

void StatusServer::send_to(Client& client) {
  const auto rest = std::string_view(client.text).substr(client.sent);
  const auto sent = ::send(client.socket.number(), rest.data(), rest.size(), MSG_NOSIGNAL);
  if (sent > 0) client.sent += static_cast<std::size_t>(sent);
  const bool may_continue = sent >= 0 || errno == EAGAIN || errno == EINTR;
  if (!may_continue || client.sent == client.text.size()) client = Client();
}

}  // namespace ddssec
