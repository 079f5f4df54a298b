#include "pki/crl_number.hpp"

#include <algorithm>

#include "pki/openssl_pointers.hpp"

namespace ddssec::pki {

CrlNumber::CrlNumber(std::uint64_t number) {
  for (; number != 0; number >>= 8) octets_.push_back(static_cast<std::uint8_t>(number));
  std::ranges::reverse(octets_);
}

CrlNumber CrlNumber::from_octets(BytesView octets) {
  CrlNumber out;
  const auto first = std::ranges::find_if(octets, [](auto octet) { return octet != 0; });
  out.octets_.assign(first, octets.end());
  return out;
}

std::optional<std::uint64_t> CrlNumber::as_uint64() const {
  if (octets_.size() > sizeof(std::uint64_t)) return std::nullopt;
  std::uint64_t out = 0;
  for (const auto octet : octets_) out = out << 8 | octet;
  return out;
}

CrlNumber CrlNumber::next() const {
  auto out = *this;
  for (auto octet = out.octets_.rbegin(); octet != out.octets_.rend(); ++octet)
    if (++*octet != 0) return out;
  out.octets_.insert(out.octets_.begin(), 1);
  return out;
}

std::strong_ordering operator<=>(const CrlNumber& a, const CrlNumber& b) {
  const auto by_length = a.octets_.size() <=> b.octets_.size();
  if (by_length != 0) return by_length;
  return std::lexicographical_compare_three_way(a.octets_.begin(), a.octets_.end(),
                                                b.octets_.begin(), b.octets_.end());
}

std::string to_string(const CrlNumber& number) {
  constexpr std::size_t kMaxOctets = 20;  // RFC 5280 5.2.3
  if (const auto small = number.as_uint64()) return std::to_string(*small);
  const auto octets = number.octets();
  if (octets.size() > kMaxOctets)
    return "of " + std::to_string(octets.size()) + " octets, more than RFC 5280 allows";
  const BignumPtr value(BN_bin2bn(octets.data(), static_cast<int>(octets.size()), nullptr));
  const OpensslTextPtr text(value ? BN_bn2dec(value.get()) : nullptr);
  return text ? text.get() : "";
}

}  // namespace ddssec::pki
