// Writes messages into a buffer of fixed size that the caller owns.
#pragma once

#include <algorithm>
#include <concepts>

#include "base/bytes.hpp"
#include "base/reader.hpp"

namespace ddssec::rtps {

/// Never writes past the end of the buffer. Data that does not fit is left out and `overflowed()`
/// stays true, so that one check after a whole submessage is sufficient. The `write` functions of
/// this folder report nothing else: their caller asks `overflowed()`. Alignment counts from the
/// first octet of the buffer.
class SpanWriter {
 public:
  explicit SpanWriter(MutableBytes out, Endian endian = Endian::little)
      : out_(out), endian_(endian) {}

  Endian endian() const { return endian_; }
  std::size_t size() const { return size_; }
  std::size_t room() const { return out_.size() - size_; }
  bool overflowed() const { return has_overflowed_; }
  BytesView view() const { return out_.first(size_); }

  /// Returns the free part of the buffer, for callers that write to it; they then call `commit`
  /// with the number of octets written.
  MutableBytes spare() { return has_overflowed_ ? MutableBytes{} : out_.subspan(size_); }
  void commit(std::size_t count) { claim(count); }
  /// Marks the writer as overflowed, as if some data had not fitted.
  void overflow() { has_overflowed_ = true; }

  /// Removes everything from `size` on, and clears the overflow.
  void rewind(std::size_t size) {
    size_ = std::min(size, size_);
    has_overflowed_ = false;
  }

  template <std::integral T>
  void write(T value) {
    if (auto place = claim(sizeof(T)); !place.empty()) store(place, value);
  }

  void write_bytes(BytesView octets) {
    if (auto place = claim(octets.size()); !place.empty()) std::ranges::copy(octets, place.begin());
  }

  /// Writes zero octets up to a multiple of `alignment`.
  void align(std::size_t alignment) { std::ranges::fill(claim(-size_ & (alignment - 1)), 0); }

  /// Overwrites an integer that was written earlier at `position`.
  template <std::integral T>
  void patch(std::size_t position, T value) {
    if (position + sizeof(T) <= size_) store(out_.subspan(position, sizeof(T)), value);
  }

 private:
  MutableBytes claim(std::size_t count) {
    if (has_overflowed_ || count > room()) {
      has_overflowed_ = true;
      return {};
    }
    size_ += count;
    return out_.subspan(size_ - count, count);
  }

  template <std::integral T>
  void store(MutableBytes place, T value) {
    const auto bits = static_cast<std::make_unsigned_t<T>>(value);
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      const auto shift = 8 * (endian_ == Endian::big ? sizeof(T) - 1 - i : i);
      place[i] = static_cast<std::uint8_t>(bits >> shift);
    }
  }

  MutableBytes out_;
  std::size_t size_ = 0;
  Endian endian_;
  bool has_overflowed_ = false;
};

}  // namespace ddssec::rtps
