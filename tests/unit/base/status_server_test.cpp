// The socket that shows a process's documents, and hostile clients.
#include "base/status_server.hpp"

#include <atomic>
#include <csignal>
#include <fcntl.h>
#include <filesystem>
#include <sys/resource.h>
#include <sys/stat.h>

#include <gmock/gmock.h>

#include "tests/support/expect_code.hpp"
#include "tests/unit/base/status_socket.hpp"

namespace ddssec {
namespace {

using std::chrono::steady_clock;
using testing::HasSubstr;

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
  std::vector<FileDescriptor> lazy;
  for (std::size_t i = 0; i < StatusServer::kMaxClients; ++i) lazy.push_back(connected(path()));
  const auto begin = steady_clock::now();
  EXPECT_EQ(answer_at(path()).size(), 1024u * 1024);
  EXPECT_LT(steady_clock::now() - begin, 4 * StatusServer::kClientTimeout);
}

TEST_F(Server, ManyClients_AreAnsweredAtABoundedRate) {
  std::atomic<unsigned> asked = 0;
  const auto server = start([&] { return std::to_string(++asked); });
  ASSERT_OK(server);
  const auto begin = steady_clock::now();
  const auto count = 2 * StatusServer::kMaxPerSecond + 1;
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
  const FileDescriptor client(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const rlimit few{4, before.rlim_max};  // fewer descriptors than poll() is given
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
    const FileDescriptor left(::socket(AF_UNIX, SOCK_STREAM, 0));
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
  const FileDescriptor folder(::open(deep.c_str(), O_PATH));
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
              server->reset();  // happens as well when the child exits
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

}  // namespace
}  // namespace ddssec
