// Random names and expressions for comparisons with another reader.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <string_view>

namespace ddssec::governance {

/// Random texts made of few characters, so that many of them match.
class RandomText {
 public:
  std::string of(std::string_view alphabet, std::size_t most) {
    std::string text(generator_() % (most + 1), ' ');
    for (auto& c : text) c = alphabet[generator_() % alphabet.size()];
    return text;
  }
  std::uint32_t number(std::uint32_t below) { return generator_() % below; }

 private:
  std::mt19937 generator_{20261121};
};

}  // namespace ddssec::governance
