// What a topic knows of its type besides the name (DDS 1.4, TypeSupport).
#pragma once

#include <functional>

#include "rtps/cdr/cdr_reader.hpp"
#include "rtps/cdr/cdr_writer.hpp"
#include "rtps/cdr/key_hash.hpp"
#include "rtps/filter/sample_view.hpp"
#include "rtps/qos/qos.hpp"
#include "rtps/reliability/change.hpp"
#include "rtps/reliability/key_payload.hpp"
#include "rtps/types/type_consistency.hpp"

namespace ddssec::rtps {

/// For octets, name and with_key alone will do; then samples of types with keys must come with
/// their key hash, and instances cannot be shown by their key.
struct TypeSupport {
  std::string name;
  bool with_key = true;
  /// Which instance a change belongs to; nothing if its payload cannot be read. Keeps what it reads
  /// into: one caller at a time.
  std::function<std::optional<KeyHash>(const Change&, bool always_md5)> key_hash = nullptr;
  /// Its serialized key, with an encapsulation.
  std::function<Bytes(const Change&)> serialized_key = nullptr;
  /// The same serialized key without any DHEADER (see KeyLayout); empty if it cannot be read.
  KeyRewriter bare_key = nullptr;
  /// What filters see samples through; they need names in the traits.
  std::function<std::unique_ptr<SampleView>()> view = nullptr;
  /// What peers are told of the type besides its name; too long ones are not told.
  TypeDescription description = {};
};

/// The encoding of a writer's samples, and the one that a reader asks for first.
inline XcdrVersion version_of(const Qos& qos) {
  const auto& list = qos.data_representation;
  return list.empty() || list.front() != DataRepresentation::xcdr2 ? XcdrVersion::xcdr1
                                                                   : XcdrVersion::xcdr2;
}

namespace detail {

template <DdsType T>
Result<T> deserialize_change(const Change& change) {
  const auto octets = change.payload.view();
  return change.key_only ? deserialize_key<T>(octets) : deserialize<T>(octets);
}

}  // namespace detail

template <DdsType T>
TypeSupport type_support() {
  TypeSupport support{.name = std::string(TypeTraits<T>::type_name), .with_key = has_key<T>()};
  support.view = [] { return std::make_unique<SampleViewOf<T>>(); };
  if constexpr (requires { TypeTraits<T>::type_information; }) {
    support.description = {to_bytes(TypeTraits<T>::type_information),
                           to_bytes(TypeTraits<T>::type_objects)};
    if (support.description.information.size() > kMostTypeInformation) support.description = {};
    if (support.description.objects.size() > kMostTypeObjects) support.description.objects.clear();
  }
  if (!support.with_key) return support;
  support.key_hash = [value = T{}, scratch = Bytes{}](
                         const Change& change, bool always_md5) mutable -> std::optional<KeyHash> {
    const auto octets = change.payload.view();
    const auto read =
        change.key_only ? deserialize_key_into(octets, value) : deserialize_into(octets, value);
    if (!read) return std::nullopt;
    const auto opened = open_payload(octets);
    return key_hash(value, scratch, always_md5, version_of(opened->encapsulation));
  };
  support.serialized_key = [](const Change& change) {
    Bytes out;
    const auto opened = open_payload(change.payload.view());
    if (const auto value = detail::deserialize_change<T>(change))
      serialize_key(*value, out, version_of(opened->encapsulation));
    return out;
  };
  support.bare_key = [](BytesView key) {
    Bytes out;
    const auto opened = open_payload(key);
    if (const auto value = deserialize_key<T>(key))
      serialize_key(*value, out, version_of(opened->encapsulation), opened->endian,
                    KeyLayout::bare);
    return out;
  };
  return support;
}

}  // namespace ddssec::rtps
