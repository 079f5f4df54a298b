#include "rtps/reliability/fragment_set.hpp"

#include <algorithm>

namespace ddssec::rtps {

namespace {

constexpr std::size_t kPageSize = FragmentSet::kFragmentsPerPage / 8;

std::uint8_t bit_of(std::uint32_t index) { return static_cast<std::uint8_t>(1u << (index % 8)); }

std::size_t octet_of(std::uint32_t index) { return index % FragmentSet::kFragmentsPerPage / 8; }

}  // namespace

FragmentSet::FragmentSet(std::uint32_t total) : total_(total), missing_(total) {}

bool FragmentSet::insert(FragmentNumber first, std::uint32_t count) {
  const auto missing_before = missing_;
  for (auto index = first.value - 1; index < first.value - 1 + count; ++index) {
    auto& page = pages_[index / kFragmentsPerPage];
    if (page.size() == 0) {
      page = Payload::uninitialized(kPageSize);
      std::ranges::fill(page.fill(), std::uint8_t{0});
    }
    auto& octet = page.fill()[octet_of(index)];
    if ((octet & bit_of(index)) == 0) --missing_;
    octet |= bit_of(index);
  }
  // first_missing_ only moves forward, so all calls together take one step for each fragment.
  while (first_missing_.value <= total_ && contains(first_missing_)) ++first_missing_.value;
  return missing_ < missing_before;
}

bool FragmentSet::contains(FragmentNumber number) const {
  const auto index = number.value - 1;
  const auto& page = pages_[index / kFragmentsPerPage];
  return page.size() > 0 && (page.view()[octet_of(index)] & bit_of(index)) != 0;
}

std::size_t FragmentSet::octets() const {
  std::size_t out = 0;
  for (const auto& page : pages_) out += page.size();
  return out;
}

FragmentNumberSet FragmentSet::missing() const {
  FragmentNumberSet out(first_missing_);
  for (auto number = first_missing_; number.value <= total_ && out.reaches(number); ++number.value)
    if (!contains(number)) out.insert(number);
  return out;
}

}  // namespace ddssec::rtps
