// Which fragments of a sample have arrived.
#pragma once

#include <array>
#include <cstdint>

#include "rtps/reliability/payload.hpp"
#include "wire/numbers.hpp"

namespace ddssec::rtps {

/// A bitmap in pages, which are allocated when the first of their fragments arrives. A sender that
/// claims many fragments and sends few causes no more work than one that claims few.
class FragmentSet {
 public:
  static constexpr std::uint32_t kFragmentsPerPage = 4096;
  static constexpr std::uint32_t kMostFragments = 32 * kFragmentsPerPage;

  /// `total` is the number of fragments of the whole sample, at most kMostFragments.
  explicit FragmentSet(std::uint32_t total = 0);

  /// Adds fragments first .. first + count - 1, which must not exceed the total. False: it had all
  /// of them.
  bool insert(FragmentNumber first, std::uint32_t count);
  bool contains(FragmentNumber number) const;
  bool is_complete() const { return missing_ == 0; }
  /// total + 1 if none is missing.
  FragmentNumber first_missing() const { return first_missing_; }
  /// Those that are missing within 256 of the first.
  FragmentNumberSet missing() const;
  /// What its pages occupy.
  std::size_t octets() const;

 private:
  std::uint32_t total_ = 0;
  std::uint32_t missing_ = 0;
  FragmentNumber first_missing_{1};
  /// Payloads because their memory is reused: nothing is allocated once samples flow.
  std::array<Payload, kMostFragments / kFragmentsPerPage> pages_;
};

}  // namespace ddssec::rtps
