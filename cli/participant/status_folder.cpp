#include "cli/participant/status_folder.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstring>
#include <dirent.h>
#include <fcntl.h>
#include <memory>
#include <optional>
#include <poll.h>
#include <ranges>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <system_error>
#include <tuple>

#include <fmt/format.h>

#include "base/errno_text.hpp"
#include "base/guarded_path.hpp"
#include "base/text.hpp"
#include "base/tool_code.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
using std::chrono::steady_clock;

// The time for all sockets of a folder together, because its owner can put many into it that never
// answer.
constexpr std::chrono::seconds kAnswerTimeout{10};
constexpr std::size_t kMaxAnswerOctets = 2 * 1024 * 1024;
constexpr std::size_t kMaxOctetsOfAll = 32 * 1024 * 1024;

std::optional<pid_t> pid_in(std::string_view name) {
  constexpr std::string_view kStart = "ddssec-", kEnd = ".sock";
  if (!name.starts_with(kStart) || !name.ends_with(kEnd)) return std::nullopt;
  name = name.substr(kStart.size(), name.size() - kStart.size() - kEnd.size());
  if (name.size() > 2 && name[name.size() - 2] == '-' && name.back() >= '2' && name.back() <= '8')
    name.remove_suffix(2);
  pid_t out = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), out);
  const bool is_number = error == std::errc() && end == name.data() + name.size();
  // A process number has no leading zeros.
  return is_number && out > 0 && fmt::to_string(out) == name ? std::optional(out) : std::nullopt;
}

// True for a text such as "2026-11-21T03:13:43Z".
bool is_time(std::string_view text) {
  constexpr std::string_view kForm = "0000-00-00T00:00:00Z";
  return std::ranges::equal(text, kForm, [](char c, char form) {
    return form == '0' ? c >= '0' && c <= '9' : c == form;
  });
}

// True if `word` is one of `words`, which are separated by '|'.
bool is_one_of(std::string_view word, std::string_view words) {
  return std::ranges::any_of(std::views::split(words, '|'),
                             [&](const auto& one) { return std::ranges::equal(one, word); });
}

// Reads the known members of an answer. The answer may come from a later version, or from a process
// that lies. Missing members raise exceptions of Json.
class AnswerReader {
 public:
  // Empty if this is no answer of ddssec's plugins.
  static std::optional<StatusFolder::Answer> answer_of(const std::string& answer) {
    AnswerReader reader;
    const auto given = Json::parse(answer);
    StatusFolder::Answer out{{}, given.at("left_out").get<std::uint64_t>()};
    reader.read(given.at("participants"), {}, out.participants);
    const bool is_ours = given.at("schema") == "ddssec-status/1" && reader.has_times_;
    return is_ours ? std::optional(std::move(out)) : std::nullopt;
  }

 private:
  template <class T>
  void read(const Json& from, const FieldOptions& options, T& to) {
    using fields_detail::kIsA;
    if constexpr (HasFields<T>) {
      std::apply([&](const auto&... all) { (read_member(from, all, to), ...); }, T::fields());
    } else if constexpr (kIsA<T, std::optional>) {
      if (!from.is_null()) read(from, options, to.emplace());
      // A word that this version does not know is left out, as the schema asks.
      if constexpr (std::same_as<T, std::optional<std::string>>)
        if (to && !options.words.empty() && !is_one_of(*to, options.words)) to.reset();
    } else if constexpr (kIsA<T, std::vector>) {
      for (const auto& element : from) read(element, options, to.emplace_back());
    } else if constexpr (std::same_as<T, std::string>) {
      // Texts are put on one line, so that a process that lies cannot write lines of its own.
      to = printable(from.get<std::string>());
      has_times_ = has_times_ && (options.def != "time" || is_time(to));
    } else {
      to = from.get<T>();
    }
  }

  template <class Owner, class T>
  void read_member(const Json& from, const Field<Owner, T>& one, Owner& to) {
    const std::string name(one.name);
    if (!fields_detail::kIsA<T, std::optional> || from.contains(name))
      read(from.at(name), one.options, to.*one.member);
  }

  bool has_times_ = true;
};

}  // namespace

bool is_running(pid_t pid) { return ::kill(pid, 0) == 0 || errno != ESRCH; }

StatusFolder::StatusFolder(fs::path path, FileDescriptor folder, uid_t owner)
    : path_(std::move(path)),
      folder_(std::move(folder)),
      owner_(owner),
      octets_left_(kMaxOctetsOfAll) {}

Result<StatusFolder> StatusFolder::open(const fs::path& path) {
  DDSSEC_ASSIGN_OR_RETURN(auto folder, open_guarded(path, O_RDONLY));
  if (!folder) {
    const int error = errno;
    const auto code = error == EACCES   ? tool_code::status_of_another_user
                      : error == ENOENT ? Code::file_not_found
                                        : Code::file_unreadable;
    return fail(code, {.document = path, .note = errno_text(error)});
  }
  struct stat status {};
  if (::fstat(folder.number(), &status) != 0)
    return fail(Code::file_unreadable, {.document = path, .note = errno_text(errno)});
  if ((status.st_mode & 022) != 0)
    return fail(tool_code::status_folder_untrusted,
                {.document = path,
                 .expected = "a folder that only its owner can write to",
                 .found = fmt::format("mode {:04o}", status.st_mode & 07777)});
  StatusFolder out(path, std::move(folder), status.st_uid);
  out.until_ = steady_clock::now() + kAnswerTimeout;
  out.list();
  return out;
}

void StatusFolder::list() {
  FileDescriptor again(::openat(folder_.number(), ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!again) return;
  const std::unique_ptr<DIR, int (*)(DIR*)> entries(::fdopendir(again.number()), ::closedir);
  if (!entries) return;
  again.release();
  while (const auto* entry = ::readdir(entries.get())) {
    const auto pid = pid_in(entry->d_name);
    if (pid && sockets_.size() == kMaxSockets) ++left_out_;
    if (pid && sockets_.size() < kMaxSockets) sockets_.push_back({*pid, entry->d_name});
  }
  // The order puts ddssec-1.sock before ddssec-1-2.sock.
  std::ranges::sort(sockets_, {}, [](const Socket& one) {
    return std::tuple(one.pid, one.name.size(), one.name);
  });
}

std::unexpected<Error> StatusFolder::socket_error(const Socket& socket, Code code,
                                                  std::string note) const {
  return fail(code, {.document = path_ / socket.name,
                     .field = fmt::format("process {}", socket.pid),
                     .note = std::move(note)});
}

Result<FileDescriptor> StatusFolder::connect(const Socket& socket) const {
  struct stat status {};
  if (::fstatat(folder_.number(), socket.name.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0)
    return socket_error(socket, tool_code::status_process_ended, errno_text(errno));
  if (!S_ISSOCK(status.st_mode))
    return socket_error(socket, tool_code::status_unanswered, "this is no socket");
  FileDescriptor out(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  // Uses the folder's descriptor, because a path may be too long for a socket address.
  const auto path = fmt::format("/proc/self/fd/{}/{}", folder_.number(), socket.name);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), std::min(path.size(), sizeof address.sun_path - 1));
  const auto* const generic = static_cast<const sockaddr*>(static_cast<const void*>(&address));
  if (out && ::connect(out.number(), generic, sizeof address) == 0) return out;
  const int error = errno;
  if (error == EACCES || error == EPERM)
    return socket_error(socket, tool_code::status_of_another_user,
                        fmt::format("the socket is of user {}", status.st_uid));
  const bool is_gone = error == ECONNREFUSED || error == ENOENT;
  if (is_gone && is_running(socket.pid))
    return socket_error(socket, tool_code::status_process_ended,
                        "the socket is of a former process with this number");
  return socket_error(socket,
                      is_gone ? tool_code::status_process_ended : tool_code::status_unanswered,
                      is_gone ? "" : errno_text(error));
}

// Root asks processes of users, so an answer of a third user in the folder is not accepted.
Status StatusFolder::check_answering(const Socket& socket, int connection) const {
  ucred peer{};
  socklen_t size = sizeof peer;
  if (::getsockopt(connection, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0)
    return socket_error(socket, tool_code::status_unanswered, errno_text(errno));
  if (peer.uid == owner_ || peer.uid == 0 || peer.uid == ::geteuid()) return {};
  return socket_error(socket, tool_code::status_of_another_user,
                      fmt::format("user {} answers in a folder of user {}", peer.uid, owner_));
}

Result<std::string> StatusFolder::read_all(const Socket& socket, int connection) {
  const auto most = std::min(kMaxAnswerOctets, octets_left_);
  std::string out;
  std::array<char, 16384> piece;
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until_ - steady_clock::now());
    pollfd polled{connection, POLLIN, 0};
    if (left.count() <= 0 || ::poll(&polled, 1, static_cast<int>(left.count())) == 0)
      return socket_error(
          socket, tool_code::status_unanswered,
          is_running(socket.pid) ? "no answer within 10 s" : "the process has ended");
    const auto count = ::recv(connection, piece.data(), piece.size(), 0);
    if (count == 0) {
      octets_left_ -= out.size();
      return out;
    }
    if (count < 0 && errno != EAGAIN && errno != EINTR)
      return socket_error(socket, tool_code::status_unanswered, errno_text(errno));
    if (count > 0) out.append(piece.data(), static_cast<std::size_t>(count));
    if (out.size() <= most) continue;
    octets_left_ -= most;
    return socket_error(socket, tool_code::status_unanswered,
                        most < kMaxAnswerOctets ? "the answers of this folder are too long together"
                                                : "the answer is too long");
  }
}

Result<StatusFolder::Answer> StatusFolder::ask(const Socket& socket) {
  DDSSEC_ASSIGN_OR_RETURN(const auto connection, connect(socket));
  DDSSEC_RETURN_IF_ERROR(check_answering(socket, connection.number()));
  DDSSEC_ASSIGN_OR_RETURN(const auto answer, read_all(socket, connection.number()));
  try {
    if (auto read = AnswerReader::answer_of(answer)) return *std::move(read);
  } catch (const Json::parse_error& error) {
    // The process has dropped the connection: it lacks memory, or was kept from sending.
    if (error.byte > answer.size())
      return socket_error(socket, tool_code::status_unanswered, "its answer is cut off");
  } catch (const Json::exception&) {
    // This is handled like any other answer that does not come from the plugins.
  }
  return socket_error(socket, tool_code::status_unanswered,
                      "what it answers is not what ddssec's plugins say");
}

}  // namespace ddssec::cli
