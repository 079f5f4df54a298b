#include "plugins/spi/symmetric_cipher.hpp"

#include <algorithm>
#include <array>

namespace ddssec::spi {
namespace {

struct Row {
  CipherMask bit;
  std::string_view name;
};
constexpr std::array kCiphers = {Row{kAes128Bit, kAes128Name}, Row{kAes256Bit, kAes256Name},
                                 Row{kChaCha20Poly1305Bit, kChaCha20Poly1305Name}};

}  // namespace

std::optional<CipherMask> cipher_of(std::string_view name) {
  const auto row = std::ranges::find(kCiphers, name, &Row::name);
  if (row == kCiphers.end()) return std::nullopt;
  return row->bit;
}

std::string names_of(CipherMask mask) {
  std::string out;
  for (const auto& row : kCiphers) {
    if ((mask & row.bit) == 0) continue;
    if (!out.empty()) out += ',';
    out += row.name;
  }
  return out.empty() ? "none" : out;
}

CipherMask ciphers_in(std::string_view names) {
  CipherMask out = 0;
  while (!names.empty()) {
    const auto comma = std::min(names.find(','), names.size());
    out |= cipher_of(names.substr(0, comma)).value_or(0);
    names.remove_prefix(std::min(comma + 1, names.size()));
  }
  return out;
}

}  // namespace ddssec::spi
