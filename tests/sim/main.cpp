// ddssec_sim: random attacks on real participants in a virtual network, from seeds. See README.md.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tests/sim/repeatable_openssl.hpp"
#include "tests/sim/schedule.hpp"

namespace {

namespace sim = ddssec::rtps::sim;

struct Options {
  std::uint64_t seed = 1;
  std::uint64_t seeds = 1;  // the number of seeds, from `seed` on
  double seconds = 0;       // CPU time after which no other seed begins
  std::string also;         // a file in which each line begins with one more seed
  int steps = 0;
  std::vector<std::string> like;  // seeds whose description lacks one of these are left out
  bool verbose = false;
};

constexpr const char* kUsage =
    "ddssec_sim [--seed N] [--seeds COUNT] [--seconds CPU] [--also FILE] [--steps HOSTILE] "
    "[--like TEXT]... [--verbose]\n";

bool read_options(int count, char** words, Options& options) {
  for (int i = 1; i < count; ++i) {
    const std::string_view word = words[i];
    if (word == "--verbose") {
      options.verbose = true;
      continue;
    }
    if (i + 1 == count) return false;
    const char* value = words[++i];
    if (word == "--seed")
      options.seed = std::strtoull(value, nullptr, 10);
    else if (word == "--seeds")
      options.seeds = std::strtoull(value, nullptr, 10);
    else if (word == "--seconds")
      options.seconds = std::strtod(value, nullptr);
    else if (word == "--also")
      options.also = value;
    else if (word == "--steps")
      options.steps = std::atoi(value);
    else if (word == "--like")
      options.like.emplace_back(value);
    else
      return false;
  }
  return true;
}

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

bool is_wanted(const std::string& description, const Options& options) {
  return std::ranges::all_of(options.like,
                             [&](const auto& text) { return description.contains(text); });
}

// The largest number of branches of all seeds, and its seed.
struct Most {
  std::uint64_t branches = 0, seed = 0;
};

// Runs a seed. False if an invariant was violated.
bool try_seed(std::uint64_t seed, const Options& options, Most& most) {
  const auto plan = sim::plan_of(seed, options.steps);
  if (!is_wanted(describe(plan), options)) return true;
  for (const auto& subject : plan.cast) properties_of(subject, *plan.protection);
  sim::make_openssl_repeatable(seed);
  if (options.verbose) std::printf("%s\n", describe(plan).c_str());
  std::fflush(stdout);
  const auto outcome = sim::run(plan);
  if (outcome.most_branches > most.branches) most = {outcome.most_branches, seed};
  if (options.verbose || outcome.violation)
    std::printf(
        "seed %llu: %ld steps, %llu datagrams, %.1f MB, %llu branches, %zu handshakes, reunion "
        "%.2f s, %016llx\n",
        static_cast<unsigned long long>(seed), outcome.step,
        static_cast<unsigned long long>(outcome.datagrams),
        static_cast<double>(outcome.most.most_octets) / 1e6,
        static_cast<unsigned long long>(outcome.most_branches), outcome.most_handshakes,
        std::chrono::duration<double>(outcome.reunion).count(),
        static_cast<unsigned long long>(outcome.fingerprint));
  if (!outcome.violation) return true;
  std::printf("VIOLATED in step %ld of seed %llu: %s\n  %s\n  %s\n", outcome.step,
              static_cast<unsigned long long>(seed),
              std::string(outcome.violation->invariant).c_str(), outcome.violation->detail.c_str(),
              describe(plan).c_str());
  return false;
}

// Returns the seeds of the file that are not tried anyway; empty if the file cannot be read.
std::optional<std::set<std::uint64_t>> other_seeds(const Options& options) {
  std::ifstream file(options.also);
  if (!file) return std::nullopt;
  std::set<std::uint64_t> out;
  for (std::string line; std::getline(file, line);) {
    const auto seed = std::strtoull(line.c_str(), nullptr, 10);
    if (seed > 0 && seed - options.seed >= options.seeds) out.insert(seed);
  }
  return out;
}

}  // namespace

int main(int count, char** words) {
  Options options;
  if (!read_options(count, words, options)) {
    std::fputs(kUsage, stderr);
    return EXIT_FAILURE;
  }
  std::uint64_t done = 0;
  Most most;
  if (!options.also.empty()) {
    const auto others = other_seeds(options);
    if (!others) {
      std::fprintf(stderr, "%s cannot be read\n", options.also.c_str());
      return EXIT_FAILURE;
    }
    for (const auto seed : *others)
      if (!try_seed(seed, options, most)) return EXIT_FAILURE;
    done = others->size();
  }
  const bool by_time = options.seconds > 0;
  for (std::uint64_t i = 0; by_time ? cpu_seconds() < options.seconds : i < options.seeds; ++i) {
    if (!try_seed(options.seed + i, options, most)) return EXIT_FAILURE;
    ++done;
  }
  std::printf(
      "%llu seeds, %.1f s of CPU: every invariant held; at most %llu branches, by seed %llu\n",
      static_cast<unsigned long long>(done), cpu_seconds(),
      static_cast<unsigned long long>(most.branches), static_cast<unsigned long long>(most.seed));
  return EXIT_SUCCESS;
}
