// Measures authentication and access control, ours and Cyclone DDS's own, through the C ABI, in
// turn in one run. It measures processor time, because this does not include other processes.
//   cyclone_host_bench --ours FOLDER --stock FOLDER --pki FOLDER --rules FOLDER [--rounds N]
//                      [--json FILE]
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/bench/command_line.hpp"
#include "tests/support/cyclone_driver.hpp"

namespace ddssec::driver {
namespace {

using Json = nlohmann::ordered_json;

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

// Returns the microseconds of processor time that all threads of this process took.
double cpu_us() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e6 + static_cast<double>(now.tv_nsec) / 1e3;
}

double time_of(const std::function<void()>& operation, int times = 1) {
  const auto start = cpu_us();
  for (int i = 0; i < times; ++i) operation();
  return (cpu_us() - start) / times;
}

// Two participants, each in a domain of its own.
struct Two {
  Two(const Paths& paths, const std::string& pki, const std::string& governance)
      : domain_a(paths),
        domain_b(paths),
        a(domain_a, pki, "a", governance),
        b(domain_b, pki, "b", governance) {}

  // Runs the handshake of both sides until each has the shared secret.
  void shake_hands() {
    Peer a_of_b, b_of_a;
    authenticate(a, b, a_of_b, b_of_a);
    for (const auto& [self, peer] : {std::pair(&a, &a_of_b), std::pair(&b, &b_of_a)}) {
      auto& auth = self->domain.authentication();
      Call call("get_shared_secret");
      call.check(auth.get_shared_secret(&auth, peer->handshake, call) != 0);
      auth.return_identity_handle(&auth, peer->identity, nullptr);
    }
  }

  Domain domain_a, domain_b;
  Participant a, b;
};

// The endpoint checks of one link.
struct Checks {
  Checks(const Paths& paths, const std::string& pki)
      : two(paths, pki, "rules"), link(two.a, two.b, "Literal0") {}

  void create_datawriter(const std::string& topic) {
    auto& access = two.domain_a.access_control();
    const DDS_Security_Qos qos{};
    const DDS_Security_PartitionQosPolicy partition{};
    const DDS_Security_DataTags tags{};
    Call call("check_create_datawriter");
    call.check(access.check_create_datawriter(&access, two.a.permissions, 0, topic.c_str(), &qos,
                                              &partition, &tags, call));
  }
  void remote_datawriter(std::string topic) {
    auto& access = two.domain_b.access_control();
    DDS_Security_PublicationBuiltinTopicDataSecure publication{};
    publication.topic_name = topic.data();
    Call call("check_remote_datawriter");
    call.check(
        access.check_remote_datawriter(&access, link.b_of_a.permissions, 0, &publication, call));
  }
  // Returns a name that no call had before, and that one pattern near the middle matches.
  std::string new_name() { return "Area5001/" + std::to_string(++names) + "/Speed1"; }

  Two two;
  Link link;
  int names = 0;
};

class Bench {
 public:
  Bench(const Paths& ours, const Paths& stock, int rounds)
      : ours_(ours), stock_(stock), rounds_(rounds) {}

  void authentication(const std::string& pki) {
    Two ours(ours_, pki, "encrypt"), stock(stock_, pki, "encrypt");
    const auto first = [&](const Paths& paths) {
      Two fresh(paths, pki, "encrypt");
      return time_of([&] { fresh.shake_hands(); });
    };
    compare(
        "handshake, new peer", [&] { return first(ours_); }, [&] { return first(stock_); });
    compare(
        "handshake, known peer", [&] { return time_of([&] { ours.shake_hands(); }, 10); },
        [&] { return time_of([&] { stock.shake_hands(); }, 10); });
  }

  void access_control(const std::string& rules) {
    std::unique_ptr<Checks> ours, stock;
    const auto load = [&](std::unique_ptr<Checks>& checks, const Paths& paths) {
      checks.reset();
      return time_of([&] { checks = std::make_unique<Checks>(paths, rules); });
    };
    compare(
        "load and join, 2 sides", [&] { return load(ours, ours_); },
        [&] { return load(stock, stock_); }, 1);
    const auto check = [&](const char* what, auto&& call) {
      compare(
          what, [&] { return time_of([&] { call(*ours); }, 2000); },
          [&] { return time_of([&] { call(*stock); }, 100); });
    };
    check("create_datawriter seen", [](Checks& c) { c.create_datawriter("Literal5000"); });
    check("create_datawriter new", [](Checks& c) { c.create_datawriter(c.new_name()); });
    check("remote_datawriter seen", [](Checks& c) { c.remote_datawriter("Literal5000"); });
    check("remote_datawriter new", [](Checks& c) { c.remote_datawriter(c.new_name()); });
  }

  const Json& json() const { return json_; }

 private:
  using Measure = std::function<double()>;

  // Measures the two in turn. Both return microseconds.
  void compare(const char* what, const Measure& ours, const Measure& stock, int rounds = 0) {
    std::vector<double> o, s, ratios;
    for (int round = 0; round < (rounds != 0 ? rounds : rounds_); ++round) {
      o.push_back(ours());
      s.push_back(stock());
      ratios.push_back(s.back() / o.back());
    }
    std::printf("%-26s %12.2f %12.2f %10.1fx\n", what, median(o), median(s), median(ratios));
    std::fflush(stdout);
    json_.push_back({{"what", what},
                     {"ours_us", median(o)},
                     {"stock_us", median(s)},
                     {"stock_over_ours", median(ratios)}});
  }

  Paths ours_, stock_;
  int rounds_;
  Json json_;
};

int run(const bench::Options& options) {
  const auto &ours = options.at("--ours"), &stock = options.at("--stock");
  Bench bench({ours + "/libddssec_authentication.so", ours + "/libddssec_access_control.so",
               ours + "/libddssec_cryptography.so"},
              {stock + "/libdds_security_auth.so", stock + "/libdds_security_ac.so",
               stock + "/libdds_security_crypto.so"},
              std::stoi(options.at("--rounds")));
  std::puts("\nus of processor time             ddssec        stock stock/ddssec");
  bench.authentication(options.at("--pki"));
  std::puts("10,000 topics in permissions, 10,000 rules in governance");
  bench.access_control(options.at("--rules"));
  if (const auto file = options.find("--json"); file != options.end())
    std::ofstream(file->second) << bench.json().dump(1) << "\n";
  return 0;
}

}  // namespace
}  // namespace ddssec::driver

int main(int argc, char** argv) {
  return ddssec::bench::main_of(argc, argv, {{"--rounds", "5"}},
                                {"--ours", "--stock", "--pki", "--rules"}, ddssec::driver::run);
}
