// Checks PID_PARTITION of announcements before Cyclone DDS compares it.
//
// The core compares the partitions of a discovered endpoint with local ones before it asks a
// plugin. Its matcher tries every position for every `*`: k of them against a name of n characters
// cost about n^(k+1) / (k+1)! steps. A run of `*` and `?` counts as one `*`. A run at the end costs
// nothing, because the matcher has then succeeded. Names without `*` and `?` are compared
// literally, like those of topics and types.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "base/bytes.hpp"
#include "base/result.hpp"

namespace ddssec::cryptography {

struct DiscoveryTopic;

/// Reads the value of the parameter, a CDR sequence of strings, in pieces of any size. The object
/// is small, so that it can be copied.
class PartitionWalk {
 public:
  static constexpr std::size_t kMaxNames = 256;         ///< the limit of access control
  static constexpr std::size_t kMaxNameOctets = 1024;   ///< the limit of access control
  static constexpr std::size_t kMaxStarsOfName = 2;     ///< stars with text after them
  static constexpr std::size_t kMaxStarsOfSample = 64;  ///< stars with text after them

  PartitionWalk() = default;
  PartitionWalk(std::uint16_t length, bool is_little) : is_little_(is_little), rest_(length) {}

  /// Reads the next octets of the value, at most rest(). Error: builtin_source_unreadable.
  Status read(const DiscoveryTopic& topic, BytesView octets);
  std::size_t rest() const { return rest_; }
  /// Returns the number of names in the value, according to its count.
  std::size_t names() const { return names_; }

 private:
  Status read_octet(const DiscoveryTopic& topic, std::uint8_t octet);
  Status read_word(const DiscoveryTopic& topic, std::uint32_t word);
  Status begin_name(const DiscoveryTopic& topic, std::uint32_t size);
  Status read_character(const DiscoveryTopic& topic, char character);
  Status count_star(const DiscoveryTopic& topic);

  bool is_little_ = false;
  bool has_count_ = false;
  bool is_in_stars_ = false;  ///< inside a run of `*` and `?` that contains a `*`
  std::uint8_t filled_ = 0;
  std::uint32_t word_ = 0;
  std::uint16_t names_ = 0;
  std::uint32_t names_left_ = 0;
  std::uint32_t name_left_ = 0;  ///< octets left of the name, including its NUL
  std::uint8_t to_pad_ = 0;
  std::uint8_t stars_ = 0;         ///< stars in the present name
  std::uint8_t stars_of_all_ = 0;  ///< stars in the whole parameter
  std::size_t rest_ = 0;           ///< octets left of the value
  std::uint8_t text_size_ = 0;
  std::array<char, 48> text_ = {};  ///< beginning of the name, for error messages
};

}  // namespace ddssec::cryptography
