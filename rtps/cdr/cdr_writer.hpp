// Serializes user types in XCDR1 and XCDR2 (XTypes 7.4).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <span>

#include "base/bytes.hpp"
#include "rtps/cdr/encapsulation.hpp"
#include "rtps/cdr/type.hpp"

namespace ddssec::rtps {

/// Appends to octets of the caller: a Bytes, which keeps its capacity from sample to sample, or a
/// PayloadBuffer, which has the same calls.
template <class Octets>
class CdrWriter {
 public:
  CdrWriter(Octets& out, XcdrVersion version, Endian endian)
      : out_(out), origin_(out.size()), version_(version), endian_(endian) {}

  template <class T>
  void put(const T& value) {
    if constexpr (detail::Primitive<T>) {
      put_number(value);
    } else if constexpr (std::is_enum_v<T>) {
      put_number(static_cast<typename detail::EnumOnWire<T>::type>(value));
    } else if constexpr (std::is_same_v<T, std::string>) {
      put_text(value);
    } else if constexpr (detail::Sequence<T>) {
      put_sequence(value);
    } else if constexpr (detail::Array<T>) {
      put_array(value);
    } else {
      put_struct(value);
    }
  }

  /// Writes only the key members. A nested struct that marks none is written with all its members.
  template <DdsType T>
  void put_key(const T& value, KeyLayout layout = KeyLayout::bare) {
    constexpr bool appendable = TypeTraits<T>::extensibility == Extensibility::appendable;
    const auto header = begin_delimited(appendable && layout == KeyLayout::delimited);
    const bool all = !has_key<T>();
    detail::for_each_member(value, [&](const auto& member) {
      using M = std::remove_cvref_t<decltype(member.value)>;
      if (!member.is_key && !all) return;
      if constexpr (DdsType<M>) {
        put_key(member.value, layout);
      } else {
        put(member.value);
      }
    });
    end_delimited(header);
  }

 private:
  template <detail::Primitive T>
  void put_number(T value) {
    if constexpr (std::is_floating_point_v<T>) {
      static_assert(sizeof(T) == 4 || sizeof(T) == 8);
      using U = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
      put_bits(std::bit_cast<U>(value));
    } else if constexpr (std::is_same_v<T, bool>) {
      put_bits(static_cast<std::uint8_t>(value));
    } else {
      put_bits(static_cast<std::make_unsigned_t<T>>(value));
    }
  }

  template <std::unsigned_integral U>
  void put_bits(U bits) {
    align(sizeof(U));
    const auto at = out_.size();
    out_.resize(at + sizeof(U));
    store(at, bits);
  }

  template <std::unsigned_integral U>
  void store(std::size_t at, U bits) {
    for (std::size_t i = 0; i < sizeof(U); ++i) {
      const auto shift = 8 * (endian_ == Endian::big ? sizeof(U) - 1 - i : i);
      out_[at + i] = static_cast<std::uint8_t>(bits >> shift);
    }
  }

  void align(std::size_t size) {
    const auto max_alignment = version_ == XcdrVersion::xcdr1 ? std::size_t{8} : std::size_t{4};
    const auto alignment = std::min(size, max_alignment);
    const auto offset = out_.size() - origin_;
    const auto padding = -offset & (alignment - 1);
    if (padding != 0) out_.resize(out_.size() + padding);
  }

  void put_text(std::string_view text) {
    put_bits(static_cast<std::uint32_t>(text.size() + 1));
    out_.insert(out_.end(), text.begin(), text.end());
    out_.push_back(0);
  }

  template <class E>
  void put_sequence(const std::vector<E>& elements) {
    const auto header = begin_delimited(!detail::kNeedsNoHeader<E>);
    put_bits(static_cast<std::uint32_t>(elements.size()));
    put_elements(elements);
    end_delimited(header);
  }

  template <class E, std::size_t N>
  void put_array(const std::array<E, N>& elements) {
    const auto header = begin_delimited(!detail::kArrayNeedsNoHeader<E>);
    put_elements(elements);
    end_delimited(header);
  }

  template <class C>
  void put_elements(const C& elements) {
    using E = typename C::value_type;
    if constexpr (std::is_same_v<E, std::uint8_t>) {
      out_.insert(out_.end(), elements.begin(), elements.end());
    } else if constexpr (detail::kIsStoredAsWritten<E>) {
      if (endian_ == Endian::little)
        put_stored<E>(elements);
      else
        put_each(elements);
    } else if constexpr (detail::Array<C> && detail::Array<E>) {
      for (const auto& inner : elements) put_elements(inner);
    } else {
      put_each(elements);
    }
  }

  template <class C>
  void put_each(const C& elements) {
    for (const auto& element : elements) put<typename C::value_type>(element);
  }

  // Elements after the first one need no padding.
  template <class E>
  void put_stored(std::span<const E> elements) {
    if (elements.empty()) return;
    align(sizeof(E));
    const auto octets = std::as_bytes(elements);
    const auto* first = static_cast<const std::uint8_t*>(static_cast<const void*>(octets.data()));
    out_.insert(out_.end(), first, first + octets.size());
  }

  template <DdsType T>
  void put_struct(const T& value) {
    const auto header = begin_delimited(TypeTraits<T>::extensibility == Extensibility::appendable);
    detail::for_each_member(value, [&](const auto& member) { put(member.value); });
    end_delimited(header);
  }

  // Begins a DHEADER, which has the size of what follows, in XCDR2 only. Returns the position after
  // it, or 0 if there is no header.
  std::size_t begin_delimited(bool wanted) {
    if (!wanted || version_ == XcdrVersion::xcdr1) return 0;
    put_bits(std::uint32_t{0});
    return out_.size();
  }
  void end_delimited(std::size_t header) {
    if (header != 0) store(header - 4, static_cast<std::uint32_t>(out_.size() - header));
  }

  Octets& out_;
  std::size_t origin_;
  XcdrVersion version_;
  Endian endian_;
};

namespace detail {

/// Returns the four octets at the beginning of a payload.
constexpr std::array<std::uint8_t, kEncapsulationSize> encapsulation_octets(Encapsulation kind,
                                                                            Endian endian) {
  const auto id =
      static_cast<std::uint16_t>(static_cast<std::uint16_t>(kind) | (endian == Endian::little));
  return {static_cast<std::uint8_t>(id >> 8), static_cast<std::uint8_t>(id), 0, 0};
}

template <class Octets>
void begin_payload(Octets& out, Encapsulation kind, Endian endian) {
  const auto octets = encapsulation_octets(kind, endian);
  out.resize(octets.size());
  for (std::size_t i = 0; i < octets.size(); ++i) out[i] = octets[i];
}
/// Pads to a multiple of 4 octets and records the padding in the options.
template <class Octets>
void end_payload(Octets& out) {
  const auto padding = -out.size() & 3u;
  out.resize(out.size() + padding);
  out[3] = static_cast<std::uint8_t>(padding);
}

template <DdsType T>
constexpr Encapsulation encapsulation_of(XcdrVersion version) {
  if (version == XcdrVersion::xcdr1) return Encapsulation::cdr;
  return TypeTraits<T>::extensibility == Extensibility::appendable ? Encapsulation::delimited_cdr2
                                                                   : Encapsulation::cdr2;
}

}  // namespace detail

/// Replaces `out` with the payload of a DATA, including its encapsulation. Allocates only while
/// `out` grows for the first time.
template <DdsType T, class Octets>
void serialize(const T& value, Octets& out, XcdrVersion version = XcdrVersion::xcdr1,
               Endian endian = Endian::little) {
  detail::begin_payload(out, detail::encapsulation_of<T>(version), endian);
  CdrWriter(out, version, endian).put(value);
  detail::end_payload(out);
}

/// As serialize, for the key alone: the payload of a dispose or unregister.
template <DdsType T, class Octets>
void serialize_key(const T& value, Octets& out, XcdrVersion version = XcdrVersion::xcdr1,
                   Endian endian = Endian::little, KeyLayout layout = KeyLayout::delimited) {
  detail::begin_payload(out, detail::encapsulation_of<T>(version), endian);
  CdrWriter(out, version, endian).put_key(value, layout);
  detail::end_payload(out);
}

}  // namespace ddssec::rtps
