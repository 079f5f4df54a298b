// Measures our cryptography and Cyclone DDS's own, through the C ABI, in turn in one run, and the
// raw cipher.
//   cyclone_plugin_bench --ours LIBRARY --stock LIBRARY [--rounds N] [--json FILE]
// The machine's clock drifts, so only the ratios of each round count. Their median is shown.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <dlfcn.h>
#include <fstream>
#include <functional>
#include <map>
#include <thread>

#include <intel-ipsec-mb.h>
#include <nlohmann/json.hpp>

#include "tests/bench/command_line.hpp"
#include "tests/support/cyclone_driver.hpp"

namespace ddssec::driver {
namespace {

using Clock = std::chrono::steady_clock;
using Operation = std::function<void()>;
using Json = nlohmann::ordered_json;

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

// Returns the nanoseconds of one call. After a few calls to warm up, it makes as many as fill
// `span`.
double time_of(const Operation& operation, std::chrono::microseconds span) {
  for (int i = 0; i < 3; ++i) operation();
  const auto start = Clock::now();
  long calls = 0;
  auto end = start;
  do {
    for (int i = 0; i < 16; ++i) operation();
    calls += 16;
    end = Clock::now();
  } while (end - start < span);
  return std::chrono::duration<double, std::nano>(end - start).count() / static_cast<double>(calls);
}

struct Comparison {
  double ours, stock, ratio, raw, over_raw;
};

// Measures them in turn, so that a slow second affects all of them.
Comparison compare(const Operation& ours, const Operation& stock, const Operation& raw,
                   int rounds) {
  std::vector<double> o, s, r, ratios, over;
  for (int round = 0; round < rounds; ++round) {
    o.push_back(time_of(ours, std::chrono::milliseconds(5)));
    s.push_back(time_of(stock, std::chrono::milliseconds(5)));
    r.push_back(raw ? time_of(raw, std::chrono::milliseconds(5)) : 0);
    ratios.push_back(s.back() / o.back());
    over.push_back(raw ? o.back() / r.back() : 0);
  }
  return {median(o), median(s), median(ratios), median(r), median(over)};
}

// The cipher with an expanded key and one malloc for each message. No plugin under this ABI can be
// faster.
class Raw {
 public:
  Raw() : manager_(alloc_mb_mgr(0)), in_(1 << 17, 1) {
    IMB_ARCH architecture{};
    init_mb_mgr_auto(manager_, &architecture);
    const std::array<std::uint8_t, 32> key{};
    manager_->gcm256_pre(key.data(), &key_);
  }
  ~Raw() { free_mb_mgr(manager_); }
  Raw(const Raw&) = delete;
  Raw& operator=(const Raw&) = delete;

  void encrypt(std::size_t size) const { run(manager_->gcm256_enc, size, 0); }
  void decrypt(std::size_t size) const { run(manager_->gcm256_dec, size, 0); }
  // Computes a GMAC. The octets must be copied to the place from which they are sent.
  void sign(std::size_t size) const { run(manager_->gcm256_enc, 0, size); }

 private:
  template <class Cipher>
  void run(Cipher cipher, std::size_t text, std::size_t signed_octets) const {
    gcm_context_data context;
    std::array<std::uint8_t, 16> tag;
    static constexpr std::array<std::uint8_t, 12> kIv{};
    auto* out = static_cast<std::uint8_t*>(std::malloc(text + signed_octets + 112));
    std::copy_n(in_.data(), signed_octets, out);
    cipher(&key_, &context, out, in_.data(), text, kIv.data(), in_.data(), signed_octets,
           tag.data(), tag.size());
    std::free(out);
  }

  IMB_MGR* manager_;
  alignas(64) mutable gcm_key_data key_;
  Octets in_;
};

Octets submessage(std::size_t size) {
  Octets octets(size, 7);
  octets[0] = 0x15;
  octets[1] = 0x05;
  octets[2] = static_cast<std::uint8_t>((size - 4) & 0xff);
  octets[3] = static_cast<std::uint8_t>((size - 4) >> 8);
  return octets;
}

Octets message(std::size_t size) {
  constexpr std::uint8_t kHeader[] = {'R', 'T', 'P', 'S', 2, 1, 1, 0x10, 1,  2,
                                      3,   4,   5,   6,   7, 8, 9, 10,   11, 12};
  auto octets = submessage(size);
  octets.insert(octets.begin(), std::begin(kHeader), std::end(kHeader));
  return octets;
}

// One kind of protection, for a link of either library.
struct Kind {
  const char* name;
  Keys (*keys)(int kind);
  Octets (*plain)(std::size_t size);
  Block (*encode)(const CryptoLink& link, const Octets& plain);
  Block (*decode)(const CryptoLink& link, const DDS_Security_OctetSeq& encoded);
  std::size_t largest;
};

const std::array<Kind, 3> kKinds = {{
    {"payload", [](int kind) { return keys_of(0, 0, kind); },
     [](std::size_t size) { return Octets(size, 7); },
     [](const CryptoLink& l, const Octets& p) { return l.sender.encode_payload(p); },
     [](const CryptoLink& l, const DDS_Security_OctetSeq& e) {
       return l.receivers.back().decode_payload(e);
     },
     65536},
    {"submessage", [](int kind) { return keys_of(0, kind, 0); }, submessage,
     [](const CryptoLink& l, const Octets& p) { return l.sender.encode_submessage(p); },
     [](const CryptoLink& l, const DDS_Security_OctetSeq& e) {
       return l.receivers.back().decode_submessage(e);
     },
     65024},
    {"message", [](int kind) { return keys_of(kind, 0, 0); }, message,
     [](const CryptoLink& l, const Octets& p) { return l.sender.encode_message(p); },
     [](const CryptoLink& l, const DDS_Security_OctetSeq& e) {
       return l.receivers.back().decode_message(e);
     },
     65024},
}};

class Bench {
 public:
  Bench(const std::string& ours, const std::string& stock, int rounds)
      : ours_(ours, "init_crypto", "finalize_crypto"),
        stock_(stock, "init_crypto", "finalize_crypto"),
        rounds_(rounds) {}

  void transformations() {
    std::puts("ns a call             size   ddssec    stock stock/ddssec     raw ddssec/raw");
    for (const auto& kind : kKinds)
      for (const int protection : {2, 1})
        for (const std::size_t size : {std::size_t{64}, std::size_t{256}, std::size_t{1024},
                                       std::size_t{8192}, kind.largest})
          measure(kind, protection, size, 1);
  }

  void origin_authentication() {
    std::puts("\norigin authentication, 256 octets, by receivers");
    for (const auto& kind : {kKinds[1], kKinds[2]})
      for (const std::size_t receivers : {1, 8, 64}) measure(kind, 4, 256, receivers);
  }

  void two_threads() {
    std::puts("\n1 -> 2 threads, 1 KiB payload ENCRYPT, a writer each (kops/s)");
    for (const auto& [name, library] : {std::pair{"ddssec", &ours_}, {"stock", &stock_}}) {
      const CryptoLink first(crypto(*library), crypto(*library), keys_of(0, 0, 2), 1);
      const CryptoLink second(crypto(*library), crypto(*library), keys_of(0, 0, 2), 1);
      const Octets plain(1024, 7);
      scale(
          name, [&] { first.sender.encode_payload(plain); },
          [&] { second.sender.encode_payload(plain); });
    }
    const Raw first, second;
    scale(
        "raw", [&] { first.encrypt(1024); }, [&] { second.encrypt(1024); });
  }

  void registration() {
    std::puts("\nregistering a remote participant with N known (us)");
    for (const auto& [name, library] : {std::pair{"ddssec", &ours_}, {"stock", &stock_}})
      register_many(name, crypto(*library));
  }

  const Json& json() const { return json_; }

 private:
  static dds_security_cryptography& crypto(Library& library) {
    return *static_cast<dds_security_cryptography*>(library.context());
  }

  void measure(const Kind& kind, int protection, std::size_t size, std::size_t receivers) {
    const auto keys = kind.keys(protection);
    const CryptoLink our_link(crypto(ours_), crypto(ours_), keys, receivers);
    const CryptoLink stock_link(crypto(stock_), crypto(stock_), keys, receivers);
    const auto plain = kind.plain(size);
    auto our_encoded = kind.encode(our_link, plain), stock_encoded = kind.encode(stock_link, plain);
    if (kind.keys(1).participant.is_rtps_protected) {
      to_machine_order(our_encoded);
      to_machine_order(stock_encoded);
    }
    static const std::map<int, const char*> kNames = {{1, "SIGN"}, {2, "ENCRYPT"}, {4, "ORIGIN"}};
    const std::string what = std::string(kind.name) + " " + kNames.at(protection);
    const bool is_signed = protection == 1;
    const bool has_raw = protection != 4;
    report(what + " enc", size, receivers,
           compare([&] { kind.encode(our_link, plain); }, [&] { kind.encode(stock_link, plain); },
                   has_raw ? Operation([&] { is_signed ? raw_.sign(size) : raw_.encrypt(size); })
                           : Operation(),
                   rounds_));
    report(what + " dec", size, receivers,
           compare([&] { kind.decode(our_link, our_encoded); },
                   [&] { kind.decode(stock_link, stock_encoded); },
                   has_raw ? Operation([&] { is_signed ? raw_.sign(size) : raw_.decrypt(size); })
                           : Operation(),
                   rounds_));
  }

  void report(const std::string& what, std::size_t size, std::size_t receivers,
              const Comparison& c) {
    std::printf("%-20s %5zu", what.c_str(), receivers > 1 ? receivers : size);
    std::printf(" %8.0f %8.0f %10.1fx", c.ours, c.stock, c.ratio);
    if (c.raw > 0) std::printf(" %8.0f %8.2fx", c.raw, c.over_raw);
    std::puts("");
    std::fflush(stdout);
    json_["transformations"].push_back({{"what", what},
                                        {"size", size},
                                        {"receivers", receivers},
                                        {"ours_ns", c.ours},
                                        {"stock_ns", c.stock},
                                        {"stock_over_ours", c.ratio},
                                        {"raw_ns", c.raw},
                                        {"ours_over_raw", c.over_raw}});
  }

  void scale(const char* name, const Operation& first, const Operation& second) {
    constexpr auto kSpan = std::chrono::milliseconds(60);
    std::vector<double> ones, twos, ratios;
    for (int round = 0; round < rounds_; ++round) {
      const double one = 1e6 / time_of(first, kSpan);
      double other = 0;
      std::thread thread([&] { other = 1e6 / time_of(second, kSpan); });
      const double mine = 1e6 / time_of(first, kSpan);
      thread.join();
      ones.push_back(one);
      twos.push_back(mine + other);
      ratios.push_back((mine + other) / one);
    }
    std::printf("%-6s %8.0f -> %8.0f  %.2fx\n", name, median(ones), median(twos), median(ratios));
    json_["two_threads"][name] = {
        {"one", median(ones)}, {"two", median(twos)}, {"scaling", median(ratios)}};
  }

  void register_many(const char* name, dds_security_cryptography& plugin) {
    auto* factory = plugin.crypto_key_factory;
    const auto keys = keys_of(2, 0, 0);
    const auto local =
        factory->register_local_participant(factory, 1, 1, nullptr, &keys.participant, nullptr);
    const MadeUpSecret secret(3);
    std::vector<DDS_Security_ParticipantCryptoHandle> remotes;
    std::printf("%-6s", name);
    for (const std::size_t known : {10, 100, 1000, 4000}) {
      std::vector<double> times;
      while (remotes.size() < known + 9) {
        const auto start = Clock::now();
        remotes.push_back(factory->register_matched_remote_participant(
            factory, local, static_cast<std::int64_t>(100 + remotes.size()), 2, secret.handle(),
            nullptr));
        const auto end = Clock::now();
        if (remotes.size() > known)
          times.push_back(std::chrono::duration<double, std::micro>(end - start).count());
      }
      std::printf("  %zu: %.2f", known, median(times));
      json_["registration"][name][std::to_string(known)] = median(times);
    }
    std::puts("");
    for (const auto remote : remotes) factory->unregister_participant(factory, remote, nullptr);
    factory->unregister_participant(factory, local, nullptr);
  }

  Library ours_;
  Library stock_;
  int rounds_;
  Raw raw_;
  Json json_;
};

int run(const bench::Options& options) {
  Bench bench(options.at("--ours"), options.at("--stock"), std::stoi(options.at("--rounds")));
  bench.transformations();
  bench.origin_authentication();
  bench.two_threads();
  bench.registration();
  if (const auto file = options.find("--json"); file != options.end())
    std::ofstream(file->second) << bench.json().dump(1) << "\n";
  return 0;
}

}  // namespace
}  // namespace ddssec::driver

int main(int argc, char** argv) {
  return ddssec::bench::main_of(argc, argv, {{"--rounds", "9"}}, {"--ours", "--stock"},
                                ddssec::driver::run);
}
