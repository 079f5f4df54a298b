// The functions that a topic needs for its type (DDS 1.4, TypeSupport).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>

#include "rtps/cdr/cdr_reader.hpp"
#include "rtps/cdr/cdr_writer.hpp"
#include "rtps/cdr/key_hash.hpp"
#include "rtps/filter/sample_view.hpp"
#include "rtps/qos/qos.hpp"
#include "rtps/reliability/change.hpp"
#include "rtps/reliability/key_payload.hpp"
#include "rtps/types/type_consistency.hpp"

namespace ddssec::rtps {

/// The functions for the type of one topic. For a topic of octets, `name` and `with_key` are
/// sufficient. Then samples of types with keys must arrive with their key hash, and the serialized
/// key of an instance is not available.
struct TypeSupport {
  std::string name;
  bool with_key = true;
  /// Returns the key hash of a change's instance; empty if the payload cannot be deserialized. Not
  /// thread-safe: it deserializes into an object of its own.
  std::function<std::optional<KeyHash>(const Change&, bool always_md5)> key_hash = nullptr;
  /// Returns the serialized key of a change, with its encapsulation.
  std::function<Bytes(const Change&)> serialized_key = nullptr;
  /// Removes the DHEADERs from a serialized key (see KeyLayout). Returns empty if the key cannot be
  /// deserialized.
  KeyRewriter bare_key = nullptr;
  /// Creates the view through which filters access samples. Filters need member names in the type's
  /// traits.
  std::function<std::unique_ptr<SampleView>()> view = nullptr;
  /// The type description that is announced to peers besides the name. Descriptions that are too
  /// long are not announced.
  TypeDescription description = {};
};

/// Returns the encoding of a writer's samples, and the one that a reader requests first.
inline XcdrVersion version_of(const Qos& qos) {
  const auto& list = qos.data_representation;
  return list.empty() || list.front() != DataRepresentation::xcdr2 ? XcdrVersion::xcdr1
                                                                   : XcdrVersion::xcdr2;
}

namespace detail {

/// A value of its own for each copy. It is not on the stack, because it may be too large for that
/// of a thread.
template <DdsType T>
class ScratchValue {
 public:
  ScratchValue() = default;
  ScratchValue(const ScratchValue&) : ScratchValue() {}
  ScratchValue(ScratchValue&&) noexcept = default;
  T& operator*() { return *value_; }

 private:
  std::unique_ptr<T> value_ = std::make_unique<T>();
};

/// A value for one call. It is on the stack unless it may be too large for that of a thread.
template <DdsType T>
class LocalValue {
 public:
  T& operator*() {
    if constexpr (kIsLarge)
      return *value_;
    else
      return value_;
  }

 private:
  static constexpr bool kIsLarge = sizeof(T) > std::size_t{64} * 1024;
  using Value = std::conditional_t<kIsLarge, std::unique_ptr<T>, T>;
  static Value make() {
    if constexpr (kIsLarge)
      return std::make_unique<T>();
    else
      return T{};
  }

  Value value_ = make();
};

template <DdsType T>
Status deserialize_change(const Change& change, T& value) {
  const auto octets = change.payload.view();
  return change.is_key_only ? deserialize_key_into(octets, value) : deserialize_into(octets, value);
}

}  // namespace detail

/// Returns the functions for T, which the code generator or the application has given TypeTraits.
template <DdsType T>
TypeSupport type_support() {
  TypeSupport support{.name = std::string(TypeTraits<T>::type_name), .with_key = has_key<T>()};
  support.view = [] { return std::make_unique<SampleViewOf<T>>(); };
  if constexpr (requires { TypeTraits<T>::type_information; }) {
    support.description = {to_bytes(TypeTraits<T>::type_information),
                           to_bytes(TypeTraits<T>::type_objects)};
    if (support.description.information.size() > kMaxTypeInformation) support.description = {};
    if (support.description.objects.size() > kMaxTypeObjects) support.description.objects.clear();
  }
  if (!support.with_key) return support;
  support.key_hash = [value = detail::ScratchValue<T>(), scratch = Bytes{}](
                         const Change& change, bool always_md5) mutable -> std::optional<KeyHash> {
    if (!detail::deserialize_change(change, *value)) return std::nullopt;
    const auto opened = open_payload(change.payload.view());
    return key_hash(*value, scratch, always_md5, version_of(opened->encapsulation));
  };
  support.serialized_key = [](const Change& change) {
    Bytes out;
    detail::LocalValue<T> value;
    const auto opened = open_payload(change.payload.view());
    if (detail::deserialize_change(change, *value))
      serialize_key(*value, out, version_of(opened->encapsulation));
    return out;
  };
  support.bare_key = [](BytesView key) {
    Bytes out;
    detail::LocalValue<T> value;
    const auto opened = open_payload(key);
    if (deserialize_key_into(key, *value))
      serialize_key(*value, out, version_of(opened->encapsulation), opened->endian,
                    KeyLayout::bare);
    return out;
  };
  return support;
}

}  // namespace ddssec::rtps
