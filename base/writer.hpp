// A cursor that writes octets into a buffer of its own.
#pragma once

#include <concepts>
#include <cstdint>
#include <string_view>
#include <type_traits>
#include <utility>

#include "base/bytes.hpp"
#include "base/reader.hpp"

namespace ddssec {

/// Appends to its own buffer. CDR alignment counts from the first octet written. Not thread-safe.
class Writer {
 public:
  /// `capacity` is the number of octets to reserve. Up to that size the buffer does not grow.
  explicit Writer(Endian endian = Endian::big, std::size_t capacity = 0) : endian_(endian) {
    octets_.reserve(capacity);
  }

  /// Appends an integer of 1, 2, 4 or 8 octets, without alignment.
  template <std::integral T>
  void write(T value) {
    using U = std::make_unsigned_t<T>;
    const auto bits = static_cast<U>(value);
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      const auto shift = 8 * (endian_ == Endian::big ? sizeof(T) - 1 - i : i);
      octets_.push_back(static_cast<std::uint8_t>(bits >> shift));
    }
  }

  /// Appends zero octets up to a multiple of the integer's size (CDR), then the integer.
  template <std::integral T>
  void write_aligned(T value) {
    align(sizeof(T));
    write(value);
  }

  void write_bytes(BytesView octets) {
    octets_.insert(octets_.end(), octets.begin(), octets.end());
  }
  /// Appends zero octets up to a multiple of `alignment`, a power of 2.
  void align(std::size_t alignment) {
    octets_.resize((octets_.size() + alignment - 1) & ~(alignment - 1));
  }

  /// Appends a CDR sequence<octet>, without padding after the last octet.
  void write_octet_sequence(BytesView octets);
  /// Appends a CDR string with its terminating NUL.
  void write_string(std::string_view text);

  std::size_t size() const { return octets_.size(); }
  BytesView view() const { return octets_; }
  /// Moves the octets out; the writer is empty afterwards.
  Bytes take() { return std::exchange(octets_, {}); }

 private:
  Bytes octets_;
  Endian endian_;
};

}  // namespace ddssec
