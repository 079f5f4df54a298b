// Requests for the key tokens that a peer sent to others. A host may answer a NACK_FRAG of the
// volatile secure reader without checking which participant the message is for.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <vector>

#include "tests/interop/insider/splice.hpp"

namespace token_requests {

using splice::Bytes;

constexpr std::uint8_t kReader[] = {0xff, 2, 2, 0xc4}, kWriter[] = {0xff, 2, 2, 0xc3};

/// True if it is an ACKNACK of the volatile secure reader.
inline bool is_acknowledgment(const Bytes& octets) {
  constexpr std::uint8_t kAckNack = 6;
  return octets.size() >= 8 && octets[0] == kAckNack &&
         std::equal(std::begin(kReader), std::end(kReader), octets.begin() + 4);
}

/// Returns a little-endian NACK_FRAG for the first fragment of that message.
inline Bytes nack_frag(std::size_t number) {
  constexpr std::size_t kFirstBit = 0x80000000;
  static std::atomic<std::size_t> count = 0;
  Bytes out = {0x12, 1, 32, 0};
  splice::append(out, kReader);
  splice::append(out, kWriter);
  for (const std::size_t word :
       {std::size_t{0}, number, std::size_t{1}, std::size_t{1}, kFirstBit, ++count})
    splice::append(out, word, 4);
  return out;
}

/// Returns what is sent instead of an acknowledgment: requests for a few of the first messages, for
/// others each time.
inline std::vector<Bytes> instead_of_acknowledgment() {
  constexpr std::size_t kMessages = 60, kAtOnce = 12;
  static std::atomic<std::size_t> next = 0;
  std::vector<Bytes> out;
  for (std::size_t i = 0; i < kAtOnce; ++i) out.push_back(nack_frag(next++ % kMessages + 1));
  return out;
}

/// True if it is a DATA of the volatile secure writer, without inline QoS, for a participant with
/// another prefix.
inline bool is_for_another(const std::uint8_t* octets, std::size_t size,
                           const std::uint8_t* own_prefix) {
  constexpr std::uint8_t kData = 0x15;
  constexpr std::size_t kWriterAt = 12, kDestinationAt = 24 + 52, kPrefix = 12;
  return size >= kDestinationAt + kPrefix && octets[0] == kData &&
         std::equal(std::begin(kWriter), std::end(kWriter), octets + kWriterAt) &&
         !std::equal(own_prefix, own_prefix + kPrefix, octets + kDestinationAt);
}

}  // namespace token_requests
