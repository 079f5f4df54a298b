// Sample, view and instance states, and SampleInfo (DDS 1.4, 2.2.2.5.1 and 2.2.2.5.4).
#pragma once

#include <cstdint>
#include <optional>

#include "base/ids.hpp"
#include "rtps/reliability/change.hpp"

namespace ddssec::rtps {

/// A set of values of an enumeration whose values are single bits.
template <class E>
struct Mask {
  std::uint32_t bits = 0;

  /// Makes the empty set.
  constexpr Mask() = default;
  /// Makes the set of one value.
  constexpr Mask(E value) : bits(static_cast<std::uint32_t>(value)) {}
  /// Returns the set of all values.
  static constexpr Mask any() { return from(~0u); }
  /// Returns the set of the values whose bits are set.
  static constexpr Mask from(std::uint32_t bits) {
    Mask mask;
    mask.bits = bits;
    return mask;
  }
  /// True if the value is in the set.
  constexpr bool contains(E value) const { return (bits & static_cast<std::uint32_t>(value)) != 0; }
  constexpr bool empty() const { return bits == 0; }
  constexpr Mask operator|(Mask other) const { return from(bits | other.bits); }
  constexpr Mask operator&(Mask other) const { return from(bits & other.bits); }
  constexpr Mask without(Mask other) const { return from(bits & ~other.bits); }
  constexpr bool operator==(const Mask&) const = default;
};

/// Says whether the reader has returned the sample before (DDS 1.4, 2.2.2.5.1).
enum class SampleState : std::uint8_t { read = 1, not_read = 2 };
/// Says whether it is the first time that the reader returns samples of the instance, or of this
/// generation of it.
enum class ViewState : std::uint8_t { new_ = 1, not_new = 2 };
/// Says whether the instance has writers, was disposed, or has lost all its writers.
enum class InstanceState : std::uint8_t {
  alive = 1,
  not_alive_disposed = 2,
  not_alive_no_writers = 4
};

constexpr Mask<SampleState> operator|(SampleState a, SampleState b) { return Mask(a) | b; }
constexpr Mask<InstanceState> operator|(InstanceState a, InstanceState b) { return Mask(a) | b; }
inline constexpr Mask<InstanceState> kNotAlive =
    InstanceState::not_alive_disposed | InstanceState::not_alive_no_writers;

/// Selects the samples for a read, a take or a ReadCondition; all of them by default.
struct States {
  Mask<SampleState> sample = Mask<SampleState>::any();
  Mask<ViewState> view = Mask<ViewState>::any();
  Mask<InstanceState> instance = Mask<InstanceState>::any();
};

/// Identifies an instance at one writer or reader; 0 is HANDLE_NIL.
struct InstanceHandle {
  std::uint64_t value = 0;
  auto operator<=>(const InstanceHandle&) const = default;
  bool is_nil() const { return value == 0; }
};

/// SampleInfo of DDS 1.4, 2.2.2.5.5.
struct SampleInfo {
  SampleState sample_state = SampleState::not_read;
  ViewState view_state = ViewState::new_;
  InstanceState instance_state = InstanceState::alive;
  std::int32_t disposed_generation_count = 0;
  std::int32_t no_writers_generation_count = 0;
  /// Number of samples of the same instance that follow in the same collection.
  std::int32_t sample_rank = 0;
  /// Number of generations between this sample and the last one of its instance in the collection.
  std::int32_t generation_rank = 0;
  /// Number of generations between this sample and the last one of its instance in the reader.
  std::int32_t absolute_generation_rank = 0;
  std::optional<Time> source_timestamp;
  InstanceHandle instance_handle;
  Guid publication_handle;  ///< the writer
  bool valid_data = true;   ///< if false, only the key and the instance state are meaningful
};

/// A serialized sample. Its payload is shared and never changed, so there is no loan to return.
struct OctetSample {
  Payload payload;           ///< the payload with its encapsulation
  bool is_key_only = false;  ///< the payload is a serialized key; empty if the key was not sent
  SampleInfo info;
  SequenceNumber number = {};  ///< number that its writer gave it; 0 if it has none
};

}  // namespace ddssec::rtps
