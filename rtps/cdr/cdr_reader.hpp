// Deserializes user types from XCDR1 and XCDR2 (XTypes 7.4). The octets come from an untrusted
// sender.
#pragma once

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <span>
#include <type_traits>

#include "base/reader.hpp"
#include "rtps/cdr/encapsulation.hpp"
#include "rtps/cdr/type.hpp"

namespace ddssec::rtps {

namespace detail {

/// Returns the smallest number of octets that a value of T takes. Counts are checked against it
/// before anything is allocated.
template <class T>
std::size_t min_size() {
  if constexpr (Primitive<T>) {
    return sizeof(T);
  } else if constexpr (std::is_enum_v<T>) {
    return sizeof(typename EnumOnWire<T>::type);
  } else if constexpr (Array<T>) {
    return std::tuple_size_v<T> * min_size<typename T::value_type>();
  } else if constexpr (DdsType<T>) {
    static const std::size_t size = [] {
      std::size_t sum = 0;
      T value{};
      for_each_member(value, [&](const auto& member) {
        sum += min_size<std::remove_cvref_t<decltype(member.value)>>();
      });
      return sum;
    }();
    return std::max<std::size_t>(1, size);
  } else {
    return 4;  // the length of a string or sequence
  }
}

}  // namespace detail

/// Reads from octets. After the first error, every `take` fails and leaves its value unchanged.
class CdrReader {
 public:
  /// The deepest nesting of types, which sequences can nest. Deeper nesting is refused.
  static constexpr int kMaxNesting = 32;

  CdrReader(BytesView octets, XcdrVersion version, Endian endian)
      : reader_(octets, endian), end_(octets.size()), version_(version) {}

  /// Returns the first error, if any: truncated, malformed, length_out_of_range.
  const Status& status() const { return status_; }
  /// True if members were absent, and so keep their former values.
  bool ended_early() const { return has_ended_early_; }
  /// True if nothing is left except padding to a multiple of 4 octets.
  bool is_exhausted() const {
    return status_ && (remaining() == 0 || (end_ % 4 == 0 && remaining() < 4));
  }
  XcdrVersion version() const { return version_; }

  template <class T>
  void take(T& value, std::size_t bound = kUnbounded, std::size_t element_bound = kUnbounded) {
    if (!status_) return;
    if constexpr (detail::Primitive<T>) {
      take_number(value);
    } else if constexpr (std::is_enum_v<T>) {
      typename detail::EnumOnWire<T>::type number = 0;
      take_number(number);
      value = static_cast<T>(number);
    } else if constexpr (std::is_same_v<T, std::string>) {
      take_text(value, bound);
    } else if constexpr (detail::Sequence<T>) {
      take_sequence(value, bound, element_bound);
    } else if constexpr (detail::Array<T>) {
      const DelimitedScope delimited(*this, !detail::kArrayNeedsNoHeader<typename T::value_type>);
      take_array(value, bound, element_bound);
    } else {
      take_struct(value);
    }
  }

  /// Reads only the key members; see CdrWriter::put_key.
  template <DdsType T>
  void take_key(T& value, KeyLayout layout) {
    constexpr bool appendable = TypeTraits<T>::extensibility == Extensibility::appendable;
    const DelimitedScope delimited(*this, appendable && layout == KeyLayout::delimited);
    const bool all = !has_key<T>();
    detail::for_each_member(value, [&](const auto& member) {
      using M = std::remove_reference_t<decltype(member.value)>;
      if (!member.is_key && !all) return;
      if constexpr (DdsType<M>) {
        take_key(member.value, layout);
      } else {
        take(member.value, member.bound, member.element_bound);
      }
    });
  }

  /// Reads only the first `members` members. The reader cannot be used after that.
  template <DdsType T>
  void take_first(T& value, std::size_t members) {
    take_struct<true>(value, members);
  }

 private:
  std::size_t remaining() const { return end_ - reader_.position(); }
  void refuse(Code code) {
    if (status_) status_ = fail(code);
  }

  bool align(std::size_t size) {
    const auto max_alignment = version_ == XcdrVersion::xcdr1 ? std::size_t{8} : std::size_t{4};
    const auto padding = -reader_.position() & (std::min(size, max_alignment) - 1);
    if (padding > remaining() || !reader_.skip(padding)) refuse(Code::truncated);
    return status_.has_value();
  }

  template <class U>
  U take_bits() {
    if (!align(sizeof(U))) return 0;
    if (sizeof(U) > remaining()) return refuse(Code::truncated), U{0};
    return *reader_.read<U>();
  }

  template <detail::Primitive T>
  void take_number(T& value) {
    if constexpr (std::is_floating_point_v<T>) {
      using U = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
      const auto bits = take_bits<U>();
      if (status_) value = std::bit_cast<T>(bits);
    } else if constexpr (std::is_same_v<T, bool>) {
      const auto octet = take_bits<std::uint8_t>();
      if (octet > 1) refuse(Code::malformed);
      if (status_) value = octet == 1;
    } else {
      const auto bits = take_bits<T>();
      if (status_) value = bits;
    }
  }

  void take_text(std::string& value, std::size_t bound);

  std::uint32_t take_count(std::size_t min_element_size, std::size_t bound) {
    const auto count = take_bits<std::uint32_t>();
    if (count > bound || count > remaining() / min_element_size) refuse(Code::length_out_of_range);
    return status_ ? count : 0;
  }

  template <class E>
  void take_sequence(std::vector<E>& value, std::size_t bound, std::size_t element_bound) {
    const DelimitedScope delimited(*this, !detail::kNeedsNoHeader<E>);
    const auto count = take_count(detail::min_size<E>(), bound);
    if (!status_) return;
    if constexpr (std::is_same_v<E, std::uint8_t>) {
      const auto octets = *reader_.read_bytes(count);
      value.assign(octets.begin(), octets.end());
    } else if (is_stored_as_written<E>()) {
      if constexpr (detail::kIsStoredAsWritten<E>) {
        value.resize(count);
        take_stored<E>(value);
      }
    } else {
      value.clear();
      for (std::uint32_t i = 0; i < count && status_; ++i) {
        E element{};
        take(element, element_bound);
        if (status_) value.push_back(std::move(element));
      }
    }
  }

  template <class E>
  bool is_stored_as_written() const {
    return detail::kIsStoredAsWritten<E> && reader_.endian() == Endian::little;
  }

  template <class E>
  void take_stored(std::span<E> numbers) {
    if (numbers.empty() || !align(sizeof(E))) return;
    if (numbers.size_bytes() > remaining()) return refuse(Code::truncated);
    const auto octets = *reader_.read_bytes(numbers.size_bytes());
    std::memcpy(numbers.data(), octets.data(), octets.size());
  }

  // The bounds are those of the array's elements.
  template <class E, std::size_t N>
  void take_array(std::array<E, N>& value, [[maybe_unused]] std::size_t bound,
                  [[maybe_unused]] std::size_t element_bound) {
    if constexpr (std::is_same_v<E, std::uint8_t>) {
      if (N > remaining() || !reader_.read_into(value)) refuse(Code::truncated);
    } else if (is_stored_as_written<E>()) {
      if constexpr (detail::kIsStoredAsWritten<E>) take_stored<E>(value);
    } else {
      for (auto& element : value)
        if constexpr (detail::Array<E>)
          take_array(element, bound, element_bound);
        else
          take(element, bound, element_bound);
    }
  }

  template <bool limited = false, DdsType T>
  void take_struct(T& value, [[maybe_unused]] std::size_t max_count = kUnbounded) {
    constexpr bool appendable = TypeTraits<T>::extensibility == Extensibility::appendable;
    if (depth_ >= kMaxNesting) return refuse(Code::length_out_of_range);
    ++depth_;
    const DelimitedScope delimited(*this, appendable);
    [[maybe_unused]] std::size_t taken = 0;
    // If an older writer's appendable type ends early, the other members keep their defaults
    // (XTypes 7.6.3.4).
    detail::for_each_member(value, [&](const auto& member) {
      if constexpr (limited)
        if (taken++ >= max_count) return;
      if (appendable && remaining() == 0)
        has_ended_early_ = true;
      else
        take(member.value, member.bound, member.element_bound);
    });
    --depth_;
  }

  /// Restricts the reader to the octets that a DHEADER announces. The destructor skips what is left
  /// of them.
  class DelimitedScope {
   public:
    DelimitedScope(CdrReader& reader, bool wanted);
    ~DelimitedScope();
    DelimitedScope(const DelimitedScope&) = delete;
    DelimitedScope& operator=(const DelimitedScope&) = delete;

   private:
    CdrReader& reader_;
    std::size_t outer_end_;
    bool is_active_;
  };

  Reader reader_;
  std::size_t end_;
  XcdrVersion version_;
  Status status_;
  int depth_ = 0;
  bool has_ended_early_ = false;
};

/// Reads the payload of a DATA, including its encapsulation. Octets after the type's last member
/// come from a newer writer and are not read. Errors: those of open_payload and CdrReader,
/// rtps_encapsulation_unsupported (a parameter list, or an encapsulation that does not fit the
/// type).
template <DdsType T>
Result<T> deserialize(BytesView payload);
/// As deserialize, for the key alone; other members keep their defaults. In XCDR2 either KeyLayout
/// is accepted, and for an appendable type also PLAIN_CDR2, which earlier versions of ddssec wrote.
template <DdsType T>
Result<T> deserialize_key(BytesView payload);
/// As deserialize, into a value that keeps its memory. After an error its content is undefined.
template <DdsType T>
Status deserialize_into(BytesView payload, T& value);
template <DdsType T>
Status deserialize_key_into(BytesView payload, T& value);
/// Reads only the first `members` members. The others keep their values, and their octets are not
/// read.
template <DdsType T>
Status deserialize_first(BytesView payload, std::size_t members, T& value);

namespace detail {

/// Returns a reader positioned after the encapsulation.
Result<CdrReader> open_reader(BytesView payload, Extensibility extensibility);
Result<CdrReader> open_key_reader(BytesView payload, Extensibility extensibility);

/// Gives all members their initial values, where they are: a T may be too large for a thread's
/// stack.
template <class T>
void reset(T& value) {
  if constexpr (std::is_nothrow_default_constructible_v<T>) {
    std::destroy_at(&value);
    std::construct_at(&value);
  } else {
    value = T{};
  }
}

template <DdsType T, class Take>
Status deserialize_with(BytesView payload, T& value, Take take) {
  auto reader = open_reader(payload, TypeTraits<T>::extensibility);
  if (!reader) return std::unexpected(reader.error());
  auto again = *reader;
  take(*reader);
  if (!reader->ended_early()) return reader->status();
  reset(value);  // absent members must not show earlier values
  take(again);
  return again.status();
}

}  // namespace detail

template <DdsType T>
Status deserialize_first(BytesView payload, std::size_t members, T& value) {
  return detail::deserialize_with(payload, value,
                                  [&](CdrReader& reader) { reader.take_first(value, members); });
}

template <DdsType T>
Status deserialize_into(BytesView payload, T& value) {
  return detail::deserialize_with(payload, value, [&](CdrReader& reader) { reader.take(value); });
}

// Nothing in the payload shows which layout it has, but the lengths do. A DHEADER counts the octets
// from there to the end, and a key with a DHEADER never has the same length as the same key without
// one. So the right layout is the one that leaves no octets over.
template <DdsType T>
Status deserialize_key_into(BytesView payload, T& value) {
  auto delimited = detail::open_key_reader(payload, TypeTraits<T>::extensibility);
  if (!delimited) return std::unexpected(delimited.error());
  auto bare = *delimited;
  detail::reset(value);
  delimited->take_key(value, KeyLayout::delimited);
  if (delimited->is_exhausted()) return {};
  detail::reset(value);
  bare.take_key(value, KeyLayout::bare);
  const bool strict = TypeTraits<T>::extensibility == Extensibility::appendable &&
                      bare.version() == XcdrVersion::xcdr2;
  if (strict && bare.status() && !bare.is_exhausted()) return fail(Code::malformed);
  return bare.status();
}

template <DdsType T>
Result<T> deserialize(BytesView payload) {
  T value{};
  if (auto read = deserialize_into(payload, value); !read) return std::unexpected(read.error());
  return value;
}

template <DdsType T>
Result<T> deserialize_key(BytesView payload) {
  T value{};
  if (auto read = deserialize_key_into(payload, value); !read) return std::unexpected(read.error());
  return value;
}

}  // namespace ddssec::rtps
