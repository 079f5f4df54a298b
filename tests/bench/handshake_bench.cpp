// Measures what two participants that meet cost each other: the processor time of both from the
// first announcement until their writers and readers are matched, with everything ENCRYPT, and the
// part of it that the authentication takes. Each participant has a process of its own, because a
// process does not read again what it has read. The processes pass datagrams to each other, and
// only their own work is counted, not that of the kernel. In each round a stranger comes that the
// process at home has never met. The public-key operations of OpenSSL alone are measured in the
// same processes between the rounds, for comparison. Usage: bench_handshake [ROUNDS]
#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/bench/public_key_operations.hpp"
#include "tests/unit/rtps_security/forwarding_authentication.hpp"
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using Us = double;  // microseconds

Us now_used() {
  timespec used{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
  return static_cast<Us>(used.tv_sec) * 1e6 + static_cast<Us>(used.tv_nsec) / 1e3;
}

// Adds the time that `work` takes to `sum`.
auto timed(Us& sum, auto&& work) {
  struct Meter {
    Us& sum;
    Us before = now_used();
    ~Meter() { sum += now_used() - before; }
  } meter{sum};
  return work();
}

void expect(bool ok, const char* what) {
  if (ok) return;
  std::fprintf(stderr, "bench_handshake: %s\n", what);
  std::_Exit(1);
}

// Measures the plugins' authentication as a part of a participant's time.
class MeteredAuthentication final : public ForwardingAuthentication {
 public:
  using ForwardingAuthentication::ForwardingAuthentication;
  Us used = 0;

  Result<RemoteIdentity> validate_remote_identity(spi::IdentityHandle local,
                                                  const std::optional<spi::Token>& request,
                                                  const spi::Token& token,
                                                  const Guid& remote) override {
    return timed(used, [&] {
      return ForwardingAuthentication::validate_remote_identity(local, request, token, remote);
    });
  }
  Result<HandshakeStep> begin_handshake_request(spi::IdentityHandle initiator,
                                                spi::IdentityHandle replier,
                                                BytesView data) override {
    return timed(used, [&] {
      return ForwardingAuthentication::begin_handshake_request(initiator, replier, data);
    });
  }
  Result<HandshakeStep> begin_handshake_reply(const spi::Token& request,
                                              spi::IdentityHandle initiator,
                                              spi::IdentityHandle replier,
                                              BytesView data) override {
    return timed(used, [&] {
      return ForwardingAuthentication::begin_handshake_reply(request, initiator, replier, data);
    });
  }
  Result<HandshakeStep> process_handshake(spi::HandshakeHandle handshake,
                                          const spi::Token& message) override {
    return timed(used,
                 [&] { return ForwardingAuthentication::process_handshake(handshake, message); });
  }
};

// One end of the connection between the processes.
struct Line {
  int fd;
  void say(BytesView octets) const {
    expect(send(fd, octets.data(), octets.size(), 0) == static_cast<ssize_t>(octets.size()),
           "the other process has ended");
  }
  Bytes hear() const {
    Bytes out(1 << 17);
    const auto size = recv(fd, out.data(), out.size(), 0);
    expect(size > 0, "the other process has ended");
    out.resize(static_cast<std::size_t>(size));
    return out;
  }
};

// The cost of a meeting, for one side or both.
struct Cost {
  Us all = 0, authentication = 0;
  Us operations = 0;   // public-key operations of the authentication
  Us permissions = 0;  // verifying the signature of the permissions

  friend Cost operator+(const Cost& a, const Cost& b) {
    return {a.all + b.all, a.authentication + b.authentication, a.operations + b.operations,
            a.permissions + b.permissions};
  }
};

using CostOctets = std::array<std::uint8_t, sizeof(Cost)>;

// The word that a side sends after its datagrams.
enum Word : std::uint8_t { go_on, matched };

// A participant with a writer and a reader, on plugins of its own.
class Side {
 public:
  Side(std::uint8_t n, const spi::PropertyList& properties)
      : host_(static_cast<std::uint8_t>(200 + n)),
        authentication_(metered(host_)),
        node_(n, properties, host_) {
    auto requested = default_reader_qos();
    requested.reliability.kind = ReliabilityKind::reliable;
    expect(node_->create_writer(square(default_writer_qos()), node_.listener, now_).has_value() &&
               node_->create_reader(square(requested), node_.listener, now_).has_value(),
           "no endpoints");
  }

  // True if the writer and the reader of a stranger are matched.
  bool is_matched() const {
    return std::ranges::count_if(node_.listener.known, [&](const Guid& id) {
             return id.prefix != node_.participant->prefix();
           }) == 2;
  }
  void say(const Line& line, std::uint32_t to, Word word) {
    for (auto& [port, octets] : std::exchange(node_.post.sent, {}))
      if (port == to) line.say(octets);
    line.say(Bytes{word});
  }
  Word hear(const Line& line) {
    for (;;) {
      const auto octets = line.hear();
      if (octets.size() == 1) return static_cast<Word>(octets[0]);
      timed(cost_.all, [&] { node_->receive(octets, now_); });
    }
  }
  void tick() {
    now_ += milliseconds(10);
    timed(cost_.all, [&] { node_->tick(now_); });
  }
  void leave() { node_->leave(); }
  // Returns the cost of the meeting that is over, and measures the bare operations now.
  Cost meeting(EVP_PKEY* key) {
    cost_.authentication = std::exchange(authentication_.used, 0);
    const auto signature = bench::sign(key);
    timed(cost_.operations, [&] { expect(bench::half_a_handshake(key, 2), "OpenSSL failed"); });
    timed(cost_.permissions, [&] { expect(bench::verify(key, signature), "OpenSSL failed"); });
    return std::exchange(cost_, {});
  }

 private:
  static MeteredAuthentication& metered(Node& host) {
    const PluginServices services{host.clock, host.random, host.events};
    auto made =
        std::make_unique<MeteredAuthentication>(authentication::make_authentication(services));
    auto& out = *made;
    host.authentication = std::move(made);
    host.access_control = access_control::make_access_control(services);
    host.cryptography = cryptography::make_cryptography(services);
    return out;
  }

  Node host_;  // has random numbers of its own
  MeteredAuthentication& authentication_;
  Node node_;
  MonotonicTime now_ = seconds(1);
  Cost cost_;
};

// Each of them meets the process at home and leaves.
void be_strangers(const Line& line, const std::vector<spi::PropertyList>& who, EVP_PKEY* key) {
  for (const auto& properties : who) {
    Side side(2, properties);
    line.hear();
    for (;;) {
      side.say(line, 7001, side.is_matched() ? matched : go_on);
      if (side.hear(line) == matched) break;
      side.tick();
    }
    line.say(std::bit_cast<CostOctets>(side.meeting(key)));
    side.leave();
    side.say(line, 7001, go_on);
  }
}

Cost meet(Side& home, const Line& line, EVP_PKEY* key) {
  line.say(Bytes{go_on});
  for (;;) {
    const bool done = home.hear(line) == matched && home.is_matched();
    home.say(line, 7002, done ? matched : go_on);
    if (done) break;
    home.tick();
  }
  CostOctets there;
  const auto octets = line.hear();
  expect(octets.size() == there.size(), "no figures");
  std::ranges::copy(octets, there.begin());
  const auto both = std::bit_cast<Cost>(there) + home.meeting(key);
  home.hear(line);
  for (int i = 0; i < 20; ++i) home.tick();
  expect(!home.is_matched(), "the stranger has left and is still matched");
  home.meeting(key);
  return both;
}

Us median(const std::vector<Cost>& costs, Us Cost::*figure) {
  std::vector<Us> values;
  for (const auto& cost : costs) values.push_back(cost.*figure);
  std::ranges::sort(values);
  return values[values.size() / 2];
}

void print(const std::vector<Cost>& costs) {
  const Us all = median(costs, &Cost::all), authentication = median(costs, &Cost::authentication);
  const Us operations = median(costs, &Cost::operations);
  const Us all_operations = operations + median(costs, &Cost::permissions);
  std::printf(
      "Two participants that meet, both sides, without a kernel, medians of %zu:\n"
      "authentication  %5.0f us, %.2fx of its public-key operations (%.0f us)\n"
      "until matched   %5.0f us, %.2fx of its public-key operations (%.0f us)\n",
      costs.size(), authentication, authentication / operations, operations, all,
      all / all_operations, all_operations);
}

int run(int rounds) {
  std::vector<std::string> topics{"*"};  // a document as long as in a system with so many topics
  for (int i = 0; i < 40; ++i)
    topics.push_back("unused/by/this/participant/" + std::to_string(1000 + i));
  const auto who = [&](const std::string& name) {
    return properties_of("CN=" + name + ",O=Example", everything(ProtectionKind::encrypt), topics);
  };
  const auto at_home = who("home");
  std::vector<spi::PropertyList> strangers;
  for (int i = 0; i < rounds; ++i) strangers.push_back(who("stranger " + std::to_string(i)));
  const pki::PkeyPtr key(EVP_EC_gen("P-256"));
  int ends[2];
  expect(key && socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends) == 0, "no way between processes");
  const auto child = fork();
  expect(child >= 0, "no second process");
  close(ends[child == 0 ? 0 : 1]);
  if (child == 0) {
    be_strangers({ends[1]}, strangers, key.get());
    std::_Exit(0);
  }
  Side home(1, at_home);
  std::vector<Cost> costs;
  for (int i = 0; i < rounds; ++i) costs.push_back(meet(home, {ends[0]}, key.get()));
  print(costs);
  return 0;
}

}  // namespace
}  // namespace ddssec::rtps

int main(int count, char** arguments) {
  const int rounds = count > 1 ? std::atoi(arguments[1]) : 100;
  return rounds > 0 ? ddssec::rtps::run(rounds) : 2;
}
