// The fragments of a sample that have arrived.
#pragma once

#include <array>
#include <cstdint>

#include "rtps/reliability/payload.hpp"
#include "wire/numbers.hpp"

namespace ddssec::rtps {

/// A bitmap in pages, each allocated when the first of its fragments arrives. So a sender that
/// announces many fragments and sends few causes no more work than one that announces few.
class FragmentSet {
 public:
  static constexpr std::uint32_t kFragmentsPerPage = 4096;
  static constexpr std::uint32_t kMaxFragments = 32 * kFragmentsPerPage;

  /// `total` is the number of fragments of the whole sample, at most kMaxFragments.
  explicit FragmentSet(std::uint32_t total = 0);

  /// Adds fragments first .. first + count - 1, which must not exceed the total. Returns false if
  /// all of them were present.
  bool insert(FragmentNumber first, std::uint32_t count);
  bool contains(FragmentNumber number) const;
  bool is_complete() const { return missing_ == 0; }
  /// Returns the missing fragments within 256 of the first missing one, which is the base of the
  /// set. If none is missing, the base is total + 1.
  FragmentNumberSet missing() const;
  /// Returns the memory of its pages, in octets.
  std::size_t octets() const;

 private:
  std::uint32_t total_ = 0;
  std::uint32_t missing_ = 0;
  FragmentNumber first_missing_{1};
  /// The pages are Payloads, because their memory is reused: nothing is allocated once samples
  /// flow.
  std::array<Payload, kMaxFragments / kFragmentsPerPage> pages_;
};

}  // namespace ddssec::rtps
