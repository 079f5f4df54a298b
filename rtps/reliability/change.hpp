// A change of an instance: what histories hold and messages carry.
#pragma once

#include <memory>
#include <optional>

#include "base/ids.hpp"
#include "rtps/wire/inline_qos.hpp"
#include "rtps/wire/numbers.hpp"
#include "rtps/wire/time.hpp"

namespace ddssec::rtps {

/// Octets that several holders share and nobody changes.
class Payload {
 public:
  Payload() = default;
  static Payload copy_of(BytesView octets) {
    auto out = uninitialized(octets.size());
    std::ranges::copy(octets, out.octets_.get());
    return out;
  }
  /// For whoever fills it in before sharing it; pages that are never written cost no memory.
  static Payload uninitialized(std::size_t size) {
    Payload out;
    out.octets_ = std::make_shared_for_overwrite<std::uint8_t[]>(size);
    out.size_ = size;
    return out;
  }
  BytesView view() const { return {octets_.get(), size_}; }
  MutableBytes fill() { return {octets_.get(), size_}; }
  std::size_t size() const { return size_; }

 private:
  std::shared_ptr<std::uint8_t[]> octets_;
  std::size_t size_ = 0;
};

struct Change {
  Guid writer;
  SequenceNumber sequence_number;
  StatusInfo status;  ///< neither: alive
  std::optional<KeyHash> key_hash;
  std::optional<Time> source_time;
  bool key_only = false;  ///< the payload is a serialized key
  Payload payload;        ///< with its encapsulation

  bool is_alive() const { return status == StatusInfo{}; }
};

}  // namespace ddssec::rtps
