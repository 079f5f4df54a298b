// Memory of the endpoints that a peer announced and that were allowed.
#pragma once

#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "governance/decision.hpp"
#include "plugins/spi/access_control.hpp"

namespace ddssec::access_control {

using governance::Action;

/// Limit for a peer's endpoint: octets of the topic name, and of each partition.
inline constexpr std::size_t kMaxNameOctets = 1024;
/// Limit for a peer's endpoint: number of partitions.
inline constexpr std::size_t kMaxPartitions = 256;
/// Limit for a peer's endpoint: octets of topic name, partitions and data tags together.
inline constexpr std::size_t kMaxRequestOctets = 32'768;

/// Checks the limits above, before anything compares or compiles what a peer announces. Error:
/// length_out_of_range.
Status check_lengths(const spi::EndpointRequest& request);
/// Checks the limit of a topic name alone. Error: length_out_of_range.
Status check_topic_length(std::string_view topic);

/// The partitions of one endpoint; expressions are compiled.
class PartitionNames {
 public:
  explicit PartitionNames(std::span<const std::string_view> names);
  /// True if the two sets match (DDS 2.2.3.13): two names are equal, or one is an expression that
  /// matches a name of the other. No partition means the partition "".
  bool overlap(const PartitionNames& others) const;
  std::vector<std::string_view> views() const;
  bool operator==(const PartitionNames& others) const;
  /// Returns the octets of memory that it needs.
  std::size_t octets() const;

 private:
  struct Name {
    bool overlaps(const Name& other) const;
    std::string text;
    std::optional<governance::Pattern> expression;
  };
  std::vector<Name> names_;
};

/// Remembers announced endpoints. The host first asks about a remote endpoint with that endpoint's
/// partitions and tags. It then asks about a match with those of the local endpoint. This class
/// connects the second question with the first. Bounded: the newest entries stay, because the
/// second question directly follows the first. Thread-safe.
class AllowedEndpoints {
 public:
  static constexpr std::size_t kMax = 32;
  /// Octets of one announcement; a larger one is not remembered.
  static constexpr std::size_t kMaxOctets = 4096;
  /// Octets of memory for all entries; the newest entry always stays.
  static constexpr std::size_t kMaxMemory = 256 * 1024;

  /// An endpoint's request, with copies of its texts.
  struct Announcement {
    Announcement(Action action, const spi::EndpointRequest& request);
    bool operator==(const Announcement&) const = default;
    /// Returns the octets of memory that it needs.
    std::size_t octets() const;

    Action action;
    std::string topic;
    PartitionNames partitions;
    spi::PropertyList data_tags;
  };
  using One = std::shared_ptr<const Announcement>;

  /// Remembers an allowed announcement.
  void note(Action action, const spi::EndpointRequest& request);
  /// Returns all announcements, newest first.
  std::vector<One> all() const;
  /// Returns the announcements of that topic, newest first.
  std::vector<One> of_topic(Action action, std::string_view topic) const;

 private:
  mutable std::mutex mutex_;
  std::list<One> newest_first_;
  std::size_t octets_ = 0;  ///< octets of memory of all entries in newest_first_
};

}  // namespace ddssec::access_control
