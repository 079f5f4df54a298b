// The socket that shows a process's documents, and clients that mean no good.
#include "base/status_server.hpp"

#include <atomic>
#include <csignal>
#include <fcntl.h>
#include <filesystem>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gmock/gmock.h>

#include "base/status_service.hpp"
#include "tests/support/expect_code.hpp"
#include "tests/support/temporary_folder.hpp"

namespace ddssec {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;
using testing::HasSubstr;
namespace fs = std::filesystem;

class Log final : public EventSink {
 public:
  void raise(const Event& event) override { events.push_back(event); }
  std::vector<Event> events;
};

sockaddr_un address_of(const std::string& path) {
  sockaddr_un out{};
  out.sun_family = AF_UNIX;
  path.copy(out.sun_path, sizeof out.sun_path - 1);
  return out;
}

Descriptor connected(const std::string& path) {
  Descriptor out(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const auto address = address_of(path);
  const auto* const generic = reinterpret_cast<const sockaddr*>(&address);
  if (::connect(out.number(), generic, sizeof address) != 0) return Descriptor();
  return out;
}

/// Empty: nothing came within the time, or nothing at all.
std::string read_all(const Descriptor& socket, std::chrono::milliseconds within = 30s) {
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

std::string answer_at(const std::string& path) { return read_all(connected(path)); }

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
  /// The result of `f` in a child.
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

TEST_F(Server, Client_GetsTheAnswerOfItsMoment) {
  int asked = 0;
  const auto server = start([&] { return std::to_string(++asked); });
  ASSERT_OK(server);
  EXPECT_EQ(answer_at(path()), "1");
  EXPECT_EQ(answer_at(path()), "2");
}

TEST_F(Server, Socket_IsOfItsUserAloneAndGoesWithTheServer) {
  {
    const auto former = ::umask(0);
    const auto server = start();
    ::umask(former);
    ASSERT_OK(server);
    struct stat status {};
    ASSERT_EQ(::stat(path().c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 07777, 0600u);
  }
  EXPECT_FALSE(has_sockets());
}

TEST_F(Server, LongAnswer_IsGivenWhole) {
  const std::string text(1024 * 1024, 'x');
  const auto server = start([&] { return text; });
  ASSERT_OK(server);
  EXPECT_EQ(answer_at(path()).size(), text.size());
}

TEST_F(Server, ClientThatSendsAndClosesAtOnce_HarmsNoOther) {
  const auto server = start();
  ASSERT_OK(server);
  for (int i = 0; i < 20; ++i) {
    const auto socket = connected(path());
    static_cast<void>(::send(socket.number(), "GET / HTTP/1.1\r\n\r\n", 18, MSG_NOSIGNAL));
  }
  EXPECT_EQ(answer_at(path()), "hello");
}

TEST_F(Server, ClientsThatDoNotRead_AreDroppedAndOthersAnswered) {
  const auto server = start([] { return std::string(1024 * 1024, 'x'); });
  ASSERT_OK(server);
  std::vector<Descriptor> lazy;
  for (std::size_t i = 0; i < StatusServer::kMostClients; ++i) lazy.push_back(connected(path()));
  const auto begin = steady_clock::now();
  EXPECT_EQ(answer_at(path()).size(), 1024u * 1024);
  EXPECT_LT(steady_clock::now() - begin, 4 * StatusServer::kPatience);
}

TEST_F(Server, ManyClients_AreAnsweredAtABoundedRate) {
  std::atomic<unsigned> asked = 0;
  const auto server = start([&] { return std::to_string(++asked); });
  ASSERT_OK(server);
  const auto begin = steady_clock::now();
  const auto count = 2 * StatusServer::kMostPerSecond + 1;
  for (unsigned i = 0; i < count; ++i) EXPECT_EQ(answer_at(path()), std::to_string(i + 1));
  EXPECT_GT(steady_clock::now() - begin, 1s);
}

TEST_F(Server, AnswerThatThrows_EndsOnlyTheConnection) {
  std::atomic<bool> fails = true;
  const auto server = start([&] { return fails ? throw std::bad_alloc() : std::string("good"); });
  ASSERT_OK(server);
  EXPECT_EQ(answer_at(path()), "");
  fails = false;
  EXPECT_EQ(answer_at(path()), "good");
}

TEST_F(Server, ProcessWithoutDescriptorsForAWhile_AnswersAgain) {
  const auto server = start();
  ASSERT_OK(server);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const Descriptor client(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const rlimit few{4, before.rlim_max};  // below what poll() is given
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &few), 0);
  const auto address = address_of(path());
  EXPECT_EQ(::connect(client.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address),
            0);
  std::this_thread::sleep_for(200ms);  // the thread finds that poll() fails
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_EQ(read_all(client), "hello");
}

TEST_F(Server, SecondLibraryOfTheProcess_HasASocketOfItsOwn) {
  const auto first = start([] { return std::string("1"); });
  const auto second = start([] { return std::string("2"); });
  ASSERT_OK(second);
  EXPECT_EQ(answer_at(path()), "1");
  EXPECT_EQ(answer_at(path("-2")), "2");
}

TEST_F(Server, SocketLeftByAKilledProcess_IsReplaced) {
  {
    const Descriptor left(::socket(AF_UNIX, SOCK_STREAM, 0));
    const auto address = address_of(path());
    ASSERT_EQ(::bind(left.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address),
              0);
  }
  const auto server = start();
  ASSERT_OK(server);
  EXPECT_EQ(answer_at(path()), "hello");
}

TEST_F(Server, FileOrLinkOfThatName_IsLeftAlone) {
  folder_.write(fs::path(path()).filename(), "precious");
  fs::create_symlink("/etc/passwd", path("-2"));
  const auto server = start();
  ASSERT_OK(server);
  EXPECT_EQ(answer_at(path("-3")), "hello");
  EXPECT_EQ(fs::file_size(path()), 8u);
  EXPECT_TRUE(fs::is_symlink(path("-2")));
}

TEST_F(Server, LongPathOfTheFolder_IsNoHindrance) {
  std::string deep = folder_.path();
  for (int i = 0; i < 10; ++i) fs::create_directory(deep += "/" + std::string(60, 'd'));
  ::chmod(deep.c_str(), 0700);
  const auto server = StatusServer::start(deep, [] { return std::string("deep"); });
  ASSERT_OK(server);
  const Descriptor folder(::open(deep.c_str(), O_PATH));
  EXPECT_EQ(answer_at("/proc/self/fd/" + std::to_string(folder.number()) + "/ddssec-" +
                      std::to_string(::getpid()) + ".sock"),
            "deep");
}

TEST_F(Server, FolderThatIsNoneOrMissingOrRelative_IsRefused) {
  const auto file = folder_.write("file", "");
  for (const auto& path : {std::string("relative"), folder_.path() + "/missing", file})
    EXPECT_CODE(StatusServer::start(path, [] { return std::string(); }), status_not_served);
}

TEST_F(Server, FolderThatOthersCanWriteTo_IsRefused) {
  for (const mode_t mode : {0770, 0707, 01777}) {
    ::chmod(folder_.path().c_str(), mode);
    const auto server = start();
    EXPECT_CODE(server, status_not_served);
    EXPECT_THAT(server.error().to_sentence(), HasSubstr("mode"));
  }
  ::chmod(folder_.path().c_str(), 0755);
  EXPECT_TRUE(start());
}

TEST_F(Server, FolderOfAnotherUser_IsRefused) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give a folder away";
  ASSERT_EQ(::chown(folder_.path().c_str(), 65534, 65534), 0);
  EXPECT_CODE(start(), status_not_served);
}

TEST_F(Server, AnotherUser_IsNotAnsweredEvenIfTheSocketIsOpenToAll) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can become another user";
  ::chmod(folder_.path().c_str(), 0755);
  const auto server = start();
  ASSERT_OK(server);
  EXPECT_EQ(as_another_user([&] { return !connected(path()); }), 0) << "its mode is 0600";
  ::chmod(path().c_str(), 0666);
  EXPECT_EQ(as_another_user([&] { return connected(path()) && answer_at(path()).empty(); }), 0);
  EXPECT_EQ(answer_at(path()), "hello");
}

TEST_F(Server, ChildOfAFork_ServesNothingAndRemovesNothing) {
  auto server = start();
  ASSERT_OK(server);
  EXPECT_EQ(in_child([&] {
              server->reset();  // as when the child exits
              return fs::exists(path());
            }),
            0);
  EXPECT_EQ(answer_at(path()), "hello");
}

TEST_F(Server, Thread_BlocksSignalsOfTheProcess) {
  sigset_t mask;
  sigemptyset(&mask);
  const auto server = start([&] {
    pthread_sigmask(SIG_SETMASK, nullptr, &mask);
    return std::string("hello");
  });
  ASSERT_OK(server);
  answer_at(path());
  EXPECT_EQ(sigismember(&mask, SIGTERM), 1);
  EXPECT_EQ(sigismember(&mask, SIGINT), 1);
}

// ---- asked for by the environment

class Service : public Server {
 protected:
  ~Service() override { ::unsetenv("DDSSEC_STATUS_DIR"); }
  Log log_;
};

TEST_F(Service, WithoutTheVariable_NoSocketIsOpened) {
  ::unsetenv("DDSSEC_STATUS_DIR");
  EXPECT_EQ(documents_shown(&log_), nullptr);
  ::setenv("DDSSEC_STATUS_DIR", "", 1);
  EXPECT_EQ(documents_shown(&log_), nullptr);
  EXPECT_TRUE(log_.events.empty());
}

TEST_F(Service, AllUsersOfAProcess_ShareOneRecordUntilTheLastLeaves) {
  ::setenv("DDSSEC_STATUS_DIR", folder_.path().c_str(), 1);
  auto first = documents_shown(&log_);
  auto second = documents_shown(&log_);
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first, second);
  EXPECT_THAT(answer_at(path()), HasSubstr("ddssec-status/1"));
  first.reset();
  EXPECT_TRUE(has_sockets());
  second.reset();
  EXPECT_FALSE(has_sockets());
}

TEST_F(Service, ChildOfAProcessThatShows_ShowsNothing) {
  ::setenv("DDSSEC_STATUS_DIR", folder_.path().c_str(), 1);
  const auto record = documents_shown(&log_);
  EXPECT_EQ(in_child([&] { return documents_shown(&log_) == nullptr; }), 0);
}

TEST_F(Service, FolderThatCannotServe_IsReportedOnce) {
  ::setenv("DDSSEC_STATUS_DIR", "/nowhere/at/all", 1);
  EXPECT_EQ(documents_shown(&log_), nullptr);
  EXPECT_EQ(documents_shown(&log_), nullptr);
  ASSERT_EQ(log_.events.size(), 1u);
  EXPECT_EQ(log_.events[0].error.code(), Code::status_not_served);
  EXPECT_EQ(log_.events[0].proof, PeerProof::not_a_peer);
}

}  // namespace
}  // namespace ddssec
