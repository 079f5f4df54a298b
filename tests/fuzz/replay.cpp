// Runs a fuzz target without libFuzzer over every file of the given folders, with every truncation
// at a coarse step and a fixed number of flipped bits. Fails if there is no seed at all.
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Octets = std::vector<std::uint8_t>;

constexpr int kFlipsPerSeed = 200;
constexpr std::size_t kTruncationsPerSeed = 100;

void run(const Octets& octets) { LLVMFuzzerTestOneInput(octets.data(), octets.size()); }

void run_variations(const Octets& seed, std::mt19937& random) {
  run(seed);
  if (seed.empty()) return;
  const std::size_t step = 1 + seed.size() / kTruncationsPerSeed;
  for (std::size_t size = 0; size < seed.size(); size += step)
    run({seed.begin(), seed.begin() + static_cast<long>(size)});
  for (int i = 0; i < kFlipsPerSeed; ++i) {
    Octets changed = seed;
    changed[random() % changed.size()] ^= static_cast<std::uint8_t>(1u << (random() % 8));
    run(changed);
  }
}

Octets content(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

int main(int argc, char** argv) {
  std::mt19937 random(1);
  int seeds = 0;
  for (int i = 1; i < argc; ++i) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(argv[i])) {
      if (!entry.is_regular_file()) continue;
      run_variations(content(entry.path()), random);
      ++seeds;
    }
  }
  std::printf("%d seeds and their variations\n", seeds);
  return seeds == 0;
}
