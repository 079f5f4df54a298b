// A link between two network namespaces that loses, repeats, delays and reorders what it carries.
// A tun device in each namespace, this program between them: real peers with real sockets, and no
// help of the kernel's traffic control.
//   faulty_link NAMESPACE_A NAMESPACE_B SEED      (paths such as /proc/123/ns/net)
// Prints "ready" once both devices "link0" are there; then takes commands, one a line:
//   loss P   duplicate P   delay P MS   ...       probabilities from 0 to 1, for both directions
//   cut      heal      quit
// Ends at the end of its input and then prints what it did.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <linux/if.h>
#include <linux/if_tun.h>
#include <optional>
#include <poll.h>
#include <queue>
#include <random>
#include <sched.h>
#include <sstream>
#include <string>
#include <sys/ioctl.h>
#include <unistd.h>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;
using Packet = std::vector<char>;
constexpr std::size_t kGreatestPacket = 65536;
constexpr std::size_t kMostWaiting = 4096;  // of a direction; further ones are lost

int refuse(const char* what) {
  std::fprintf(stderr, "faulty_link: %s: %s\n", what, std::strerror(errno));
  return -1;
}

/// A tun device in the namespace at `path`.
int open_device(const char* path) {
  const int space = open(path, O_RDONLY | O_CLOEXEC);
  if (space < 0 || setns(space, CLONE_NEWNET) != 0) return refuse(path);
  close(space);
  const int device = open("/dev/net/tun", O_RDWR | O_CLOEXEC | O_NONBLOCK);
  if (device < 0) return refuse("/dev/net/tun");
  ifreq request{};
  std::strcpy(request.ifr_name, "link0");
  request.ifr_flags = IFF_TUN | IFF_NO_PI;
  return ioctl(device, TUNSETIFF, &request) == 0 ? device : refuse("TUNSETIFF");
}

struct Faults {
  double loss = 0, duplicate = 0, delayed = 0;
  std::chrono::microseconds longest{0};
  bool cut = false;
};

struct Counts {
  unsigned long carried = 0, lost = 0, repeated = 0, delayed = 0;
};

/// One way across the link, with a random sequence of its own.
class Direction {
 public:
  Direction(int from, int to, unsigned seed) : from_(from), to_(to), random_(seed) {}

  /// Takes what arrived, a share of it at a time.
  void receive(const Faults& faults, Clock::time_point now) {
    static std::array<char, kGreatestPacket> buffer;
    for (int i = 0; i < 64; ++i) {
      const auto size = read(from_, buffer.data(), buffer.size());
      if (size <= 0) return;
      take({buffer.data(), buffer.data() + size}, faults, now);
    }
  }

  void send_due(Clock::time_point now) {
    for (; !waiting_.empty() && waiting_.top().due <= now; waiting_.pop()) {
      const auto& packet = waiting_.top().packet;
      if (write(to_, packet.data(), packet.size()) == static_cast<ssize_t>(packet.size()))
        ++counts_.carried;
      else
        ++counts_.lost;
    }
  }

  std::optional<Clock::time_point> next() const {
    return waiting_.empty() ? std::nullopt : std::optional(waiting_.top().due);
  }
  const Counts& counts() const { return counts_; }

 private:
  struct Waiting {
    Clock::time_point due;
    unsigned long number;  // the same instant: as they came
    Packet packet;
    bool operator<(const Waiting& other) const {
      return std::pair(due, number) > std::pair(other.due, other.number);
    }
  };

  bool happens(double probability) {
    return std::uniform_real_distribution<>(0, 1)(random_) < probability;
  }

  void take(Packet packet, const Faults& faults, Clock::time_point now) {
    const bool lost = happens(faults.loss), twice = happens(faults.duplicate);
    if (faults.cut || lost || waiting_.size() >= kMostWaiting) {
      ++counts_.lost;
      return;
    }
    if (twice) {
      ++counts_.repeated;
      put(packet, faults, now);
    }
    put(std::move(packet), faults, now);
  }

  void put(Packet packet, const Faults& faults, Clock::time_point now) {
    if (happens(faults.delayed)) {
      ++counts_.delayed;
      now += std::chrono::microseconds(
          std::uniform_int_distribution<long>(0, faults.longest.count())(random_));
    }
    waiting_.push({now, ++number_, std::move(packet)});
  }

  int from_, to_;
  std::mt19937 random_;
  unsigned long number_ = 0;
  std::priority_queue<Waiting> waiting_;
  Counts counts_;
};

/// False at a word it does not know.
bool obey(std::istringstream line, Faults& faults) {
  for (std::string word; line >> word;) {
    double milliseconds = 0;
    if (word == "cut" || word == "heal")
      faults.cut = word == "cut";
    else if (word == "loss")
      line >> faults.loss;
    else if (word == "duplicate")
      line >> faults.duplicate;
    else if (word == "delay" && line >> faults.delayed >> milliseconds)
      faults.longest = std::chrono::microseconds(static_cast<long>(milliseconds * 1000));
    else
      return false;
  }
  return !line.bad();
}

/// What came on standard input, as lines; false at its end or at "quit".
bool read_commands(std::string& rest, Faults& faults) {
  char buffer[512];
  const auto size = read(STDIN_FILENO, buffer, sizeof buffer);
  if (size <= 0) return false;
  rest.append(buffer, static_cast<std::size_t>(size));
  for (std::size_t end; (end = rest.find('\n')) != std::string::npos; rest.erase(0, end + 1)) {
    const auto line = rest.substr(0, end);
    if (line == "quit") return false;
    std::printf("%s\n", obey(std::istringstream(line), faults) ? "ok" : "unknown command");
    std::fflush(stdout);
  }
  return true;
}

int milliseconds_until(const std::array<Direction, 2>& ways) {
  auto until = Clock::time_point::max();
  for (const auto& way : ways) until = std::min(until, way.next().value_or(until));
  if (until == Clock::time_point::max()) return -1;
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
  return std::max(0, static_cast<int>(left.count()));
}

void carry(std::array<Direction, 2>& ways, std::array<pollfd, 3> watched) {
  Faults faults;
  std::string rest;
  for (;;) {
    if (poll(watched.data(), watched.size(), milliseconds_until(ways)) < 0) return;
    if (watched[2].revents != 0 && !read_commands(rest, faults)) return;
    for (std::size_t i = 0; i < ways.size(); ++i)
      if (watched[i].revents != 0) ways[i].receive(faults, Clock::now());
    for (auto& way : ways) way.send_due(Clock::now());
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: %s NAMESPACE_A NAMESPACE_B SEED\n", argv[0]);
    return 2;
  }
  const int a = open_device(argv[1]), b = a < 0 ? -1 : open_device(argv[2]);
  if (b < 0) return 3;
  const auto seed = static_cast<unsigned>(std::strtoul(argv[3], nullptr, 10));
  std::puts("ready"), std::fflush(stdout);
  std::array ways{Direction(a, b, 2 * seed), Direction(b, a, 2 * seed + 1)};
  carry(ways, {pollfd{a, POLLIN, 0}, {b, POLLIN, 0}, {STDIN_FILENO, POLLIN, 0}});
  for (const auto& way : ways)
    std::printf("carried %lu lost %lu repeated %lu delayed %lu\n", way.counts().carried,
                way.counts().lost, way.counts().repeated, way.counts().delayed);
  return 0;
}
