// Sequence and fragment numbers, bounded sets of them, and counts (RTPS 9.4.2.5, 9.4.2.6, 9.4.2.8,
// 8.3.5.10).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <compare>
#include <cstdint>

#include "base/reader.hpp"
#include "base/result.hpp"

namespace ddssec::rtps {

/// Counts the changes of one writer from 1.
struct SequenceNumber {
  std::int64_t value = 0;
  auto operator<=>(const SequenceNumber&) const = default;
  constexpr SequenceNumber next() const { return {value + 1}; }
  constexpr SequenceNumber previous() const { return {value - 1}; }
};

/// No honest writer reaches this number. Larger ones are refused when they are read, so that no
/// later addition can overflow.
inline constexpr SequenceNumber kMaxSequenceNumber{std::int64_t{1} << 62};

constexpr bool is_valid(SequenceNumber number) {
  return number.value >= 1 && number <= kMaxSequenceNumber;
}

/// Compares counts of HEARTBEATs and requests, which wrap around. Any value may arrive from the
/// network.
constexpr bool is_later(std::int32_t count, std::int32_t than) {
  const auto ahead = static_cast<std::uint32_t>(count) - static_cast<std::uint32_t>(than);
  return static_cast<std::int32_t>(ahead) > 0;
}

/// Counts the fragments of one sample from 1.
struct FragmentNumber {
  std::uint32_t value = 0;
  auto operator<=>(const FragmentNumber&) const = default;
};

inline constexpr std::uint32_t kMaxBitsPerSet = 256;

/// The numbers base + i for each bit i that is set. Bits are counted from the most significant bit
/// of the first word. Stores its bits in 32 octets and allocates nothing.
template <class Number>
class NumberSet {
 public:
  using Value = decltype(Number::value);

  NumberSet() = default;
  explicit NumberSet(Number base) : base_(base) {}

  Number base() const { return base_; }
  /// Returns how many numbers from the base on the set covers, contained or not.
  std::uint32_t size() const { return bits_; }
  bool empty() const { return bits_ == 0; }

  /// True if `number` is in base .. base + 255.
  bool reaches(Number number) const {
    return number >= base_ &&
           static_cast<std::uint64_t>(number.value - base_.value) < kMaxBitsPerSet;
  }
  /// Adds a number that the set reaches; ignores others and returns false.
  bool insert(Number number) {
    if (!reaches(number)) return false;
    const auto bit = static_cast<std::uint32_t>(number.value - base_.value);
    words_[bit / 32] |= 0x80000000u >> (bit % 32);
    bits_ = std::max(bits_, bit + 1);
    return true;
  }
  bool contains(Number number) const {
    if (!reaches(number)) return false;
    const auto bit = static_cast<std::uint32_t>(number.value - base_.value);
    return bit < bits_ && (words_[bit / 32] & (0x80000000u >> (bit % 32))) != 0;
  }
  /// Calls `f(Number)` for each contained number, in order.
  template <class F>
  void for_each(F&& f) const {
    for (std::uint32_t word = 0; word * 32 < bits_; ++word) {
      for (auto left = words_[word]; left != 0;) {
        const auto bit = static_cast<std::uint32_t>(std::countl_zero(left));
        left &= ~(0x80000000u >> bit);
        f(Number{base_.value + static_cast<Value>(word * 32 + bit)});
      }
    }
  }
  bool operator==(const NumberSet&) const = default;

  /// Reads the bitmap after the base. Bits beyond the count are dropped. Errors: truncated,
  /// rtps_set_invalid.
  Status read_bits(Reader& reader) {
    const auto bits = reader.read<std::uint32_t>();
    if (!bits) return std::unexpected(bits.error());
    if (*bits > kMaxBitsPerSet) return fail(Code::rtps_set_invalid);
    for (std::uint32_t word = 0; word * 32 < *bits; ++word) {
      const auto read = reader.read<std::uint32_t>();
      if (!read) return std::unexpected(read.error());
      const auto used = std::min<std::uint32_t>(32, *bits - word * 32);
      words_[word] = *read & (0xffffffffu << (32 - used));
    }
    bits_ = *bits;
    return {};
  }
  template <class Out>
  void write_bits(Out& out) const {
    out.write(bits_);
    for (std::uint32_t word = 0; word * 32 < bits_; ++word) out.write(words_[word]);
  }

 private:
  Number base_{};
  std::uint32_t bits_ = 0;
  std::array<std::uint32_t, kMaxBitsPerSet / 32> words_{};
};

using SequenceNumberSet = NumberSet<SequenceNumber>;
using FragmentNumberSet = NumberSet<FragmentNumber>;

/// Accepts any 64 bits; the caller checks the value. Error: truncated.
Result<SequenceNumber> read_any_sequence_number(Reader& reader);
/// Accepts 1 .. kMaxSequenceNumber. Errors: truncated, rtps_number_invalid.
Result<SequenceNumber> read_sequence_number(Reader& reader);
/// `min_base` is 0 where a pre-emptive ACKNACK is allowed, otherwise 1. Errors: truncated,
/// rtps_number_invalid, rtps_set_invalid.
Result<SequenceNumberSet> read_sequence_number_set(Reader& reader, std::int64_t min_base);
/// The base is at least 1. Errors: truncated, rtps_number_invalid, rtps_set_invalid.
Result<FragmentNumberSet> read_fragment_number_set(Reader& reader);

template <class Out>
void write_sequence_number(Out& out, SequenceNumber number) {
  out.write(static_cast<std::int32_t>(number.value >> 32));
  out.write(static_cast<std::uint32_t>(number.value));
}
template <class Out>
void write_set(Out& out, const SequenceNumberSet& set) {
  write_sequence_number(out, set.base());
  set.write_bits(out);
}
template <class Out>
void write_set(Out& out, const FragmentNumberSet& set) {
  out.write(set.base().value);
  set.write_bits(out);
}

}  // namespace ddssec::rtps
