// A link between two or more network namespaces that loses, repeats, delays and reorders what it
// carries. Each namespace has a tun device, and this program stands between them, so the peers are
// real ones with real sockets, without the kernel's traffic control. The n-th namespace has the
// IPv4 address that ends in n. A packet to a group goes to all others, to each with faults of its
// own.
//   faulty_link SEED NAMESPACE NAMESPACE...       (paths such as /proc/123/ns/net)
// Prints "ready" once all devices "link0" exist. Then it reads commands, one on each line:
//   loss P   duplicate P   delay P MS   ...       probabilities from 0 to 1, for all directions
//   cut      heal      quit
//   lose WHAT N     from now on messages of a kind that the n-th namespace sends are lost: with
//                   "keys" those of the key exchange, otherwise those that hold this word;
//                   lose WHAT 0 ends that
//   hold WHAT N     the same, but the messages arrive when hold WHAT 0 ends it
//   taken           answers how many messages these two commands have lost or held so far
// It ends at the end of its input, and then prints what it did.
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
#include <string_view>
#include <sys/ioctl.h>
#include <unistd.h>
#include <utility>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;
using Packet = std::vector<char>;
constexpr std::size_t kMaxPacket = 65536;
constexpr std::size_t kMaxWaiting = 4096;  // of each direction; further ones are lost

int refuse(const char* what) {
  std::fprintf(stderr, "faulty_link: %s: %s\n", what, std::strerror(errno));
  return -1;
}

// Opens a tun device in the namespace at `path`.
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
  std::string lost_kind = {};
  std::size_t loses_of = 0;  // the number of a namespace, from 1 on
  bool holds = false;        // holds messages instead of losing them
  unsigned long taken = 0;   // the number of such messages
};

struct Counts {
  unsigned long carried = 0, lost = 0, repeated = 0, delayed = 0;
};

// The way to one namespace, with a random sequence of its own.
class Direction {
 public:
  Direction(int to, unsigned seed) : to_(to), random_(seed) {}

  void take(const Packet& packet, const Faults& faults, Clock::time_point now) {
    const bool lost = happens(faults.loss), twice = happens(faults.duplicate);
    if (faults.cut || lost || waiting_.size() >= kMaxWaiting) {
      ++counts_.lost;
      return;
    }
    if (twice) {
      ++counts_.repeated;
      put(packet, faults, now);
    }
    put(packet, faults, now);
  }

  void lose() { ++counts_.lost; }

  void hold(const Packet& packet) {
    ++counts_.delayed;
    if (held_.size() < kMaxWaiting) held_.push_back(packet);
  }
  void release(Clock::time_point now) {
    for (auto& packet : std::exchange(held_, {})) put(std::move(packet), {}, now);
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
    unsigned long number;  // in the order of arrival, for the same instant
    Packet packet;
    bool operator<(const Waiting& other) const {
      return std::pair(due, number) > std::pair(other.due, other.number);
    }
  };

  bool happens(double probability) {
    return std::uniform_real_distribution<>(0, 1)(random_) < probability;
  }

  void put(Packet packet, const Faults& faults, Clock::time_point now) {
    if (happens(faults.delayed)) {
      ++counts_.delayed;
      now += std::chrono::microseconds(
          std::uniform_int_distribution<long>(0, faults.longest.count())(random_));
    }
    waiting_.push({now, ++number_, std::move(packet)});
  }

  int to_;
  std::vector<Packet> held_;
  std::mt19937 random_;
  unsigned long number_ = 0;
  std::priority_queue<Waiting> waiting_;
  Counts counts_;
};

// Returns false at a word that it does not know.
bool obey(std::istringstream line, Faults& faults) {
  for (std::string word; line >> word;) {
    double milliseconds = 0;
    if (word == "cut" || word == "heal")
      faults.cut = word == "cut";
    else if (word == "lose" || word == "hold")
      line >> faults.lost_kind >> faults.loses_of, faults.holds = word == "hold";
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

// Reads commands from standard input, as lines. Returns false at its end or at "quit".
bool read_commands(std::string& rest, Faults& faults) {
  char buffer[512];
  const auto size = read(STDIN_FILENO, buffer, sizeof buffer);
  if (size <= 0) return false;
  rest.append(buffer, static_cast<std::size_t>(size));
  for (std::size_t end; (end = rest.find('\n')) != std::string::npos; rest.erase(0, end + 1)) {
    const auto line = rest.substr(0, end);
    if (line == "quit") return false;
    if (line == "taken")
      std::printf("%lu\n", faults.taken);
    else
      std::printf("%s\n", obey(std::istringstream(line), faults) ? "ok" : "unknown command");
    std::fflush(stdout);
  }
  return true;
}

int milliseconds_until(const std::vector<Direction>& ways) {
  auto until = Clock::time_point::max();
  for (const auto& way : ways) until = std::min(until, way.next().value_or(until));
  if (until == Clock::time_point::max()) return -1;
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
  return std::max(0, static_cast<int>(left.count()));
}

bool holds(const Packet& packet, std::string_view word) {
  return !std::ranges::search(packet, word).empty();
}

// True if a packet holds a submessage that ParticipantVolatileMessageSecure protects, with
// AES-256-GCM and the key id 0, which no other endpoint has. False if it also holds a message of
// the handshake: under load Cyclone DDS puts the last one together with an ACKNACK of the key
// exchange.
bool holds_key_exchange(const Packet& packet) {
  constexpr std::array<char, 12> kLittle = {0x31, 1, 20, 0, 0, 0, 0, 4, 0, 0, 0, 0};
  constexpr std::array<char, 12> kBig = {0x31, 0, 0, 20, 0, 0, 0, 4, 0, 0, 0, 0};
  if (holds(packet, "dds.sec.auth")) return false;
  return !std::ranges::search(packet, kLittle).empty() ||
         !std::ranges::search(packet, kBig).empty();
}

bool is_of_kind(const Packet& packet, const std::string& kind) {
  return kind == "keys" ? holds_key_exchange(packet) : holds(packet, kind);
}

// Reads what arrived at the device of the n-th namespace, a part of it at a time.
void receive(int device, std::size_t n, std::vector<Direction>& ways, Faults& faults) {
  static std::array<char, kMaxPacket> buffer;
  constexpr std::size_t kDestination = 16, kMinPacket = 20;
  const auto now = Clock::now();
  for (int i = 0; i < 64; ++i) {
    const auto size = read(device, buffer.data(), buffer.size());
    if (size <= 0) return;
    if (static_cast<std::size_t>(size) < kMinPacket || buffer[0] >> 4 != 4) continue;
    const Packet packet(buffer.data(), buffer.data() + size);
    const auto high = static_cast<unsigned char>(packet[kDestination]);
    const std::size_t last = static_cast<unsigned char>(packet[kDestination + 3]);
    const bool is_group = high >= 224;
    const bool is_lost = faults.loses_of == n + 1 && is_of_kind(packet, faults.lost_kind);
    faults.taken += is_lost ? 1 : 0;
    for (std::size_t to = 0; to < ways.size(); ++to) {
      if (to == n || !(is_group || last == to + 1)) continue;
      if (!is_lost)
        ways[to].take(packet, faults, now);
      else
        faults.holds ? ways[to].hold(packet) : ways[to].lose();
    }
  }
}

void carry(const std::vector<int>& devices, std::vector<Direction>& ways) {
  std::vector<pollfd> watched{{STDIN_FILENO, POLLIN, 0}};
  for (const int device : devices) watched.push_back({device, POLLIN, 0});
  Faults faults;
  std::string rest;
  for (;;) {
    if (poll(watched.data(), watched.size(), milliseconds_until(ways)) < 0) return;
    if (watched[0].revents != 0 && !read_commands(rest, faults)) return;
    for (std::size_t i = 0; i < devices.size(); ++i)
      if (watched[i + 1].revents != 0) receive(devices[i], i, ways, faults);
    for (auto& way : ways) {
      if (faults.loses_of == 0) way.release(Clock::now());
      way.send_due(Clock::now());
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: %s SEED NAMESPACE NAMESPACE...\n", argv[0]);
    return 2;
  }
  const auto seed = static_cast<unsigned>(std::strtoul(argv[1], nullptr, 10));
  std::vector<int> devices;
  std::vector<Direction> ways;
  for (int i = 2; i < argc; ++i) {
    devices.push_back(open_device(argv[i]));
    if (devices.back() < 0) return 3;
    ways.emplace_back(devices.back(),
                      seed * static_cast<unsigned>(argc) + static_cast<unsigned>(i));
  }
  std::puts("ready"), std::fflush(stdout);
  carry(devices, ways);
  for (const auto& way : ways)
    std::printf("carried %lu lost %lu repeated %lu delayed %lu\n", way.counts().carried,
                way.counts().lost, way.counts().repeated, way.counts().delayed);
  return 0;
}
