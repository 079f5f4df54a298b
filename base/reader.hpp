// A cursor that cannot leave its bounds. Octets of a peer are read with it (docs/contributing.md).
#pragma once

#include <concepts>
#include <cstdint>
#include <string_view>
#include <type_traits>
#include <utility>

#include "base/bytes.hpp"
#include "base/result.hpp"

namespace ddssec {

enum class Endian : std::uint8_t { big, little };

/// Reads forward over borrowed octets. A failed read leaves the cursor where it was. CDR alignment
/// counts from the first octet given to the constructor. Not thread-safe.
class Reader {
 public:
  explicit Reader(BytesView octets, Endian endian = Endian::big)
      : octets_(octets), endian_(endian) {}

  std::size_t position() const { return position_; }
  std::size_t remaining() const { return octets_.size() - position_; }
  bool at_end() const { return remaining() == 0; }
  BytesView rest() const { return octets_.subspan(position_); }
  Endian endian() const { return endian_; }

  /// Reads an unsigned or signed integer of 1, 2, 4 or 8 octets, without alignment. Error:
  /// truncated.
  template <std::integral T>
  Result<T> read() {
    if (remaining() < sizeof(T)) return fail(Code::truncated);
    using U = std::make_unsigned_t<T>;
    U value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      const auto shift = 8 * (endian_ == Endian::big ? sizeof(T) - 1 - i : i);
      value = static_cast<U>(value | static_cast<U>(U{octets_[position_ + i]} << shift));
    }
    position_ += sizeof(T);
    return static_cast<T>(value);
  }

  /// Skips to a multiple of the integer's size (CDR) and reads the integer. Error: truncated.
  template <std::integral T>
  Result<T> read_aligned() {
    const auto start = position_;
    if (auto status = align(sizeof(T)); !status) return std::unexpected(std::move(status).error());
    auto value = read<T>();
    if (!value) position_ = start;
    return value;
  }

  /// Returns the next `count` octets, borrowed. Error: truncated.
  Result<BytesView> read_bytes(std::size_t count);

  /// Copies as many octets as `out` holds. Error: truncated.
  Status read_into(MutableBytes out);

  /// Skips to a multiple of `alignment` (1, 2, 4 or 8). Error: truncated.
  Status align(std::size_t alignment);

  /// Skips `count` octets. Error: truncated.
  Status skip(std::size_t count);

  /// Reads a CDR sequence<octet>: aligned uint32 length, then the octets, which are borrowed.
  /// Error: truncated.
  Result<BytesView> read_octet_sequence();

  /// Reads a CDR string: aligned uint32 length including the NUL, text, NUL. Length 0 is read as
  /// "", because some peers send it. Errors: truncated; malformed (a NUL inside the text, or no NUL
  /// at the end).
  Result<std::string_view> read_string();

  /// Reads a CDR sequence length for elements of at least `min_element_size` octets. Fails if the
  /// remaining octets cannot hold that many elements, so that a false length causes no allocation.
  /// Errors: truncated, length_out_of_range.
  Result<std::uint32_t> read_count(std::size_t min_element_size);

  /// Succeeds if no octets are left. Error: trailing_octets.
  Status finish() const;

 private:
  BytesView octets_;
  std::size_t position_ = 0;
  Endian endian_;
};

}  // namespace ddssec
