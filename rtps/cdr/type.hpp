// How a C++ struct describes its serialized form: reader, writer, sizes and keys use one list of
// members.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace ddssec::rtps {

/// Says whether further members may be added to a type (XTypes 1.3, 7.2.2.4.2). MUTABLE is not
/// supported.
enum class Extensibility : std::uint8_t { final_type, appendable };

/// The layout of a key alone in XCDR2. `delimited` has DHEADERs for appendable types, like their
/// samples (XTypes 1.3, 7.6.3.4 and 7.6.8). `bare` has none; Cyclone DDS up to 0.10 reads and
/// writes it. Key hashes are computed from the bare layout.
enum class KeyLayout : std::uint8_t { delimited, bare };

/// To be specialised for each user type:
///   static constexpr std::string_view type_name = "Module::Type";
///   static constexpr Extensibility extensibility = Extensibility::final_type;
///   template <class Self, class Visit> static void members(Self& self, Visit&& visit) {
///     visit(key(self.color, 128), self.x, bounded(self.data, 1000));
///   }
/// or, for content filters, with the names of the IDL:
///     visit(named("color", key(self.color, 128)), named("x", self.x));
/// For loans (FlatType), with the places of all members, in the order of the struct:
///   static constexpr std::array<MemberPlace, 2> layout = {
///       {{offsetof(S, a), kFlatSize<decltype(S::a)>}, {offsetof(S, b),
///       kFlatSize<decltype(S::b)>}}};
/// Members may be bool, integers, floating point numbers, enumerations (32 bits), std::string,
/// std::vector, std::array and other types with traits.
template <class T>
struct TypeTraits;

template <class T>
concept DdsType = requires {
  TypeTraits<std::remove_const_t<T>>::type_name;
};

inline constexpr std::size_t kUnbounded = std::numeric_limits<std::size_t>::max();

/// The description of a member, with properties that C++ cannot express.
template <class T>
struct Member {
  T& value;
  bool is_key = false;
  std::size_t bound = kUnbounded;  ///< the largest number of characters or elements
  /// The name in the IDL; if it is empty, filters cannot use the member.
  std::string_view name = {};
  std::size_t element_bound = kUnbounded;  ///< the bound of a sequence's elements
};

// In the traits of a type, each of these describes a member; they can be nested. `value` is
// referenced, not copied.

/// Describes a member that belongs to the key (@key).
template <class T>
constexpr Member<T> key(T& value, std::size_t bound = kUnbounded) {
  return {value, true, bound};
}
/// Describes a string or sequence of at most `bound` characters or elements.
template <class T>
constexpr Member<T> bounded(T& value, std::size_t bound) {
  return {value, false, bound};
}
/// Describes a member with its name in the IDL, by which filters refer to it.
template <class T>
constexpr Member<T> named(std::string_view name, T& value) {
  return {value, false, kUnbounded, name};
}
/// As named above, for a member that has further properties.
template <class T>
constexpr Member<T> named(std::string_view name, Member<T> member) {
  member.name = name;
  return member;
}

/// Describes a sequence whose elements, strings or sequences, are at most `bound` long.
template <class T>
constexpr Member<T> with_element_bound(T& value, std::size_t bound) {
  return {value, false, kUnbounded, {}, bound};
}
/// As with_element_bound above, for a member that has further properties.
template <class T>
constexpr Member<T> with_element_bound(Member<T> member, std::size_t bound) {
  member.element_bound = bound;
  return member;
}

/// An enumerator with its name in the IDL.
struct EnumLabel {
  std::string_view name;
  std::int32_t value = 0;
};

/// May be specialised for enumerations, so that filters know their labels:
///   static constexpr EnumLabel labels[] = {{"RED", 0}, {"GREEN", 1}};
/// An enumeration takes 32 bits on the wire, whatever its C++ type, unless these say otherwise:
///   static constexpr bool by_width = true;  // @bit_bound: as many as the C++ type
template <class E>
struct EnumTraits {
  static constexpr std::array<EnumLabel, 0> labels = {};
};

namespace detail {

template <class T>
constexpr Member<T> as_member(T& value) {
  return {value};
}
template <class T>
constexpr Member<T> as_member(const Member<T>& member) {
  return member;
}
template <class T>
constexpr Member<T> as_member(Member<T>&& member) {
  return member;
}

/// True for a sequence of IDL, which is a std::vector.
template <class T>
struct IsVector : std::false_type {};
template <class T>
struct IsVector<std::vector<T>> : std::true_type {};
/// True for an array of IDL, which is a std::array.
template <class T>
struct IsArray : std::false_type {};
template <class T, std::size_t N>
struct IsArray<std::array<T, N>> : std::true_type {};

template <class T>
concept Primitive = std::is_arithmetic_v<T>;
template <class T>
concept Sequence = IsVector<T>::value;
template <class T>
concept Array = IsArray<T>::value;

/// True if numbers of this type are in memory as they are written in little-endian order.
template <class T>
inline constexpr bool kIsStoredAsWritten =
    Primitive<T> && !std::is_same_v<T, bool> && sizeof(T) <= 8 &&
    std::endian::native == std::endian::little;

/// The type of an enumeration on the wire.
template <class E>
struct EnumOnWire {
  using type = std::int32_t;
};
template <class E>
requires(EnumTraits<E>::by_width) struct EnumOnWire<E> {
  using type = std::underlying_type_t<E>;
};

/// True if XCDR2 has no DHEADER before a collection of these elements. An array of arrays is one
/// array with several dimensions, so its innermost elements decide.
template <class T>
inline constexpr bool kNeedsNoHeader = Primitive<T>;
template <class T>
inline constexpr bool kArrayNeedsNoHeader = kNeedsNoHeader<T>;
template <class T, std::size_t N>
inline constexpr bool kArrayNeedsNoHeader<std::array<T, N>> = kArrayNeedsNoHeader<T>;

/// Calls `f(Member)` for each member of `self`.
template <class Self, class F>
void for_each_member(Self& self, F&& f) {
  TypeTraits<std::remove_const_t<Self>>::members(
      self, [&]<class... M>(M&&... members) { (f(as_member(std::forward<M>(members))), ...); });
}

}  // namespace detail

/// Where a member is in its struct, in octets.
struct MemberPlace {
  std::size_t offset = 0;
  std::size_t size = 0;  ///< kFlatSize
};

namespace detail {

/// See FlatType.
template <class T>
consteval bool is_flat();

template <class T>
consteval std::size_t flat_size() {
  if constexpr (std::is_same_v<T, bool>) {
    return 0;
  } else if constexpr (Primitive<T>) {
    return sizeof(T) <= 8 && alignof(T) == sizeof(T) ? sizeof(T) : 0;
  } else if constexpr (std::is_enum_v<T>) {
    return sizeof(typename EnumOnWire<T>::type) == sizeof(T) ? sizeof(T) : 0;
  } else if constexpr (Array<T>) {
    return flat_size<typename T::value_type>() * std::tuple_size_v<T>;
  } else if constexpr (DdsType<T>) {
    return is_flat<T>() ? sizeof(T) : 0;
  } else {
    return 0;
  }
}

}  // namespace detail

/// The size of a member that is in memory as it is in a sample: a number, an enumeration of the
/// size that it has on the wire, an array of these, or a flat struct. 0 for all others. Any octets
/// are a value of such a member, which is why it is not for bool.
template <class T>
inline constexpr std::size_t kFlatSize = detail::flat_size<T>();

namespace detail {

// Without padding, each member is where XCDR1 has it, too: numbers are aligned to their size.
template <class T>
consteval bool is_flat() {
  if constexpr (std::endian::native == std::endian::little && std::is_trivially_copyable_v<T> &&
                requires { TypeTraits<T>::layout; }) {
    std::size_t end = 0;
    for (const MemberPlace& place : TypeTraits<T>::layout) {
      if (place.size == 0 || place.offset != end) return false;
      end += place.size;
    }
    return end == sizeof(T) && TypeTraits<T>::extensibility == Extensibility::final_type;
  } else {
    return false;
  }
}

}  // namespace detail

/// A @final type that is in memory as it is in a little-endian sample in XCDR1, so that it can be
/// written and read in place (rtps/dcps/loans.hpp): numbers, enumerations, arrays and structs of
/// these, without bool and without padding. ddssec_idl_generate recognizes such types.
template <class T>
concept FlatType = DdsType<T> && detail::is_flat<T>();

/// True if any member is a key, so that the topic has instances.
template <DdsType T>
bool has_key() {
  static const bool has = [] {
    bool any = false;
    const auto value = std::make_unique<T>();  // it may be too large for a thread's stack
    detail::for_each_member(*value, [&](const auto& member) { any = any || member.is_key; });
    return any;
  }();
  return has;
}

}  // namespace ddssec::rtps
