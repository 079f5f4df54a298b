#include "governance/byte_classes.hpp"

#include "base/never_destroyed.hpp"

namespace ddssec::governance {
namespace {

std::string ordered_octets() {
  std::string order = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_/-.";
  const auto add = [&](int from, int to) {
    for (int octet = from; octet <= to; ++octet) {
      if (order.find(static_cast<char>(octet)) == order.npos) order += static_cast<char>(octet);
    }
  };
  add('!', '~');
  add(' ', ' ');
  add(0x80, 0xFF);
  add(0x01, 0x7F);
  return order;
}

}  // namespace

const std::string& octets_by_readability() {
  static const NeverDestroyed<std::string> kOrder(ordered_octets());
  return *kOrder;
}

void ByteClasses::separate(const std::bitset<256>& set) {
  // Each group is split into the octets inside and outside the set; at most 256 groups remain.
  std::array<std::uint16_t, 512> renamed{};
  std::uint16_t next = 0;
  for (std::size_t octet = 0; octet < group_.size(); ++octet) {
    auto& name = renamed[static_cast<std::size_t>(group_[octet] * 2 + set.test(octet))];
    if (name == 0) name = ++next;
    group_[octet] = static_cast<std::uint16_t>(name - 1);
  }
}

void ByteClasses::number() {
  for (std::size_t octet = 0; octet < single_.size(); ++octet) {
    if (single_.test(octet)) separate(std::bitset<256>().set(octet));
  }
  std::array<int, 256> number_of{};
  number_of.fill(-1);
  class_.fill(kNone);
  shown_.clear();
  for (const char c : octets_by_readability()) {
    const auto octet = static_cast<std::uint8_t>(c);
    auto& number = number_of[group_[octet]];
    if (number < 0) {
      number = static_cast<int>(shown_.size());
      shown_.push_back(octet);
    }
    class_[octet] = static_cast<Class>(number);
  }
}

}  // namespace ddssec::governance
