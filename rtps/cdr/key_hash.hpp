// KEY_HASH, which identifies the instance of a change (RTPS 9.6.4.8).
#pragma once

#include <algorithm>
#include <memory>

#include "base/hash.hpp"
#include "rtps/cdr/cdr_writer.hpp"
#include "wire/inline_qos.hpp"

namespace ddssec::rtps {

namespace detail {

/// Returns the largest position after the key of T if it begins at `offset`, or kUnbounded.
template <class T, XcdrVersion version>
std::size_t max_key_size(std::size_t offset, std::size_t bound, bool keys_only) {
  const auto aligned = [](std::size_t at, std::size_t size) {
    const auto to = std::min<std::size_t>(size, version == XcdrVersion::xcdr1 ? 8 : 4);
    return (at + to - 1) & ~(to - 1);
  };
  if constexpr (Primitive<T>) {
    return aligned(offset, sizeof(T)) + sizeof(T);
  } else if constexpr (std::is_enum_v<T>) {
    return max_key_size<typename EnumOnWire<T>::type, version>(offset, bound, keys_only);
  } else if constexpr (std::is_same_v<T, std::string>) {
    return bound == kUnbounded ? kUnbounded : aligned(offset, 4) + 4 + bound + 1;
  } else if constexpr (Array<T>) {
    for (std::size_t i = 0; i < std::tuple_size_v<T> && offset != kUnbounded; ++i)
      offset = max_key_size<typename T::value_type, version>(offset, bound, keys_only);
    return offset;
  } else if constexpr (DdsType<T>) {
    const auto value = std::make_unique<T>();
    const bool all = !keys_only || !has_key<T>();
    for_each_member(*value, [&](const auto& member) {
      using M = std::remove_cvref_t<decltype(member.value)>;
      if (offset != kUnbounded && (member.is_key || all))
        offset = max_key_size<M, version>(offset, member.bound, keys_only);
    });
    return offset;
  } else {
    return kUnbounded;  // sequences may be far above 16 octets, whatever their bound
  }
}

KeyHash key_hash_of(BytesView big_endian_key, bool always_md5);

}  // namespace detail

/// Returns the key hash of `value`'s instance. `scratch` keeps its capacity. `always_md5` is for
/// topics whose key is protected (DDS-Security 1.2, clause 7.4.4). `version` is that of the
/// samples, as other vendors do it. It makes a difference if a member of 8 octets follows one of 4.
template <DdsType T>
KeyHash key_hash(const T& value, Bytes& scratch, bool always_md5 = false,
                 XcdrVersion version = XcdrVersion::xcdr1) {
  static const bool fits1 = detail::max_key_size<T, XcdrVersion::xcdr1>(0, kUnbounded, true) <= 16;
  static const bool fits2 = detail::max_key_size<T, XcdrVersion::xcdr2>(0, kUnbounded, true) <= 16;
  scratch.clear();
  CdrWriter(scratch, version, Endian::big).put_key(value);
  return detail::key_hash_of(scratch,
                             always_md5 || !(version == XcdrVersion::xcdr1 ? fits1 : fits2));
}

}  // namespace ddssec::rtps
