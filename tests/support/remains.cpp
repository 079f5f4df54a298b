#include "tests/support/remains.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <sstream>
#include <unistd.h>

namespace ddssec::test {
namespace {

constexpr std::size_t kChunk = std::size_t{1} << 16;
constexpr std::size_t kOverlap = 64;  // more octets than any needle has
// The largest mapping that is searched. Shadow memory of sanitizers and the like is larger.
constexpr std::size_t kMaxMapping = std::size_t{256} << 20;

// The octets that are searched. They are not on the stack, because a deep call would write over the
// remains there.
std::array<std::uint8_t, kChunk + kOverlap> chunk;

struct Mapping {
  std::uintptr_t begin = 0, end = 0;
  std::string name;
};

std::vector<Mapping> writable_mappings() {
  std::ifstream maps("/proc/self/maps");
  std::vector<Mapping> out;
  for (std::string line; std::getline(maps, line);) {
    std::istringstream words(line);
    Mapping mapping;
    char dash = 0;
    std::string rights, offset, device, inode;
    words >> std::hex >> mapping.begin >> dash >> mapping.end >> rights >> offset >> device >>
        inode >> mapping.name;
    if (rights.starts_with("rw") && mapping.end - mapping.begin <= kMaxMapping)
      out.push_back(std::move(mapping));
  }
  return out;
}

// Calls `look(octets, address)` for all of a mapping except the place into which the octets are
// read.
template <class F>
void each_chunk(int memory, const Mapping& mapping, F&& look) {
  const auto own = reinterpret_cast<std::uintptr_t>(chunk.data());
  for (auto at = mapping.begin; at < mapping.end; at += kChunk) {
    if (at < own + chunk.size() && own < at + chunk.size()) continue;
    const auto want = std::min<std::size_t>(chunk.size(), mapping.end - at);
    const auto got = pread(memory, chunk.data(), want, static_cast<off_t>(at));
    if (got <= 0) continue;
    const auto octets = std::span(chunk).first(static_cast<std::size_t>(got));
    for (auto& octet : octets) octet = static_cast<std::uint8_t>(~octet);
    look(octets, at);
  }
}

}  // namespace

void Remains::look_for(std::string name, BytesView secret) {
  const auto window = std::min(secret.size(), kWindow);
  for (std::size_t at = 0; at + window <= secret.size(); at += window) {
    Bytes inverted(window);
    std::ranges::transform(secret.subspan(at, window), inverted.begin(),
                           [](std::uint8_t octet) { return static_cast<std::uint8_t>(~octet); });
    needles_.push_back({name + " at " + std::to_string(at), std::move(inverted)});
  }
}

std::vector<std::string> Remains::find() const {
  std::vector<std::string> found(needles_.size());
  const int memory = open("/proc/self/mem", O_RDONLY | O_CLOEXEC);
  if (memory < 0) return {"/proc/self/mem cannot be read"};
  for (const auto& mapping : writable_mappings())
    each_chunk(memory, mapping, [&](std::span<std::uint8_t> octets, std::uintptr_t address) {
      for (std::size_t i = 0; i < needles_.size(); ++i) {
        const auto& needle = needles_[i].inverted;
        const auto* const hit = memmem(octets.data(), octets.size(), needle.data(), needle.size());
        if (hit == nullptr || !found[i].empty()) continue;
        std::ostringstream text;
        text << needles_[i].name << " is at 0x" << std::hex
             << address +
                    static_cast<std::size_t>(static_cast<const std::uint8_t*>(hit) - octets.data())
             << " of " << (mapping.name.empty() ? "anonymous memory" : mapping.name);
        found[i] = text.str();
      }
    });
  close(memory);
  std::erase(found, "");
  return found;
}

}  // namespace ddssec::test
