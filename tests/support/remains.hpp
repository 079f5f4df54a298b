// Searches the writable memory of this process (stacks, heap and everything else) for remains of
// secrets.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/bytes.hpp"

namespace ddssec::test {

/// Secrets to look for. They are kept inverted, so that the search does not find them here.
class Remains {
 public:
  static constexpr std::size_t kWindow = 16;

  /// Adds a secret of at least 8 octets. Of a longer one, any kWindow octets in a row that begin at
  /// a multiple of kWindow count, because the allocator writes over the beginning of what was
  /// freed.
  void look_for(std::string name, BytesView secret);
  std::size_t size() const { return needles_.size(); }
  /// Returns the names of the secrets found, each with one address and its mapping; empty if
  /// nothing is left.
  std::vector<std::string> find() const;

 private:
  struct Needle {
    std::string name;
    Bytes inverted;
  };
  std::vector<Needle> needles_;
};

/// Runs `f` far down the stack, where a later search does not write over what it left.
template <class F>
[[gnu::noinline]] void at_depth(F&& f) {
  volatile std::uint8_t room[std::size_t{1} << 16];
  room[0] = 0;
  f();
  room[1] = room[0];
}

}  // namespace ddssec::test
