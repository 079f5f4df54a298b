// What a peer's announcements asked for and were allowed.
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

/// Of a peer's endpoint: the topic name, and each partition.
inline constexpr std::size_t kMaxNameOctets = 1024;
/// Of a peer's endpoint.
inline constexpr std::size_t kMaxPartitions = 256;
/// Of a peer's endpoint: topic name, partitions and data tags together.
inline constexpr std::size_t kMaxRequestOctets = 32'768;

/// Bounds what a peer announces, before anything compares or compiles it.
/// Errors: length_out_of_range.
Status check_lengths(const spi::EndpointRequest& request);
Status check_topic_length(std::string_view topic);

/// The partitions of one endpoint, those that are expressions compiled.
class PartitionNames {
 public:
  explicit PartitionNames(std::span<const std::string_view> names);
  /// DDS 2.2.3.13: any two are equal, or one is an expression that the other, a name, fits. No
  /// partition is the partition "".
  bool meet(const PartitionNames& others) const;
  std::vector<std::string_view> views() const;
  bool operator==(const PartitionNames& others) const;
  /// Of memory.
  std::size_t octets() const;

 private:
  struct Name {
    bool meets(const Name& other) const;
    std::string text;
    std::optional<governance::Pattern> expression;
  };
  std::vector<Name> names_;
};

/// The host asks about a remote endpoint by its own partitions and tags, and about a match by those
/// of our endpoint: this is how the second question knows of the first. Bounded; the newest stay,
/// and the host asks the second right after the first. Thread-safe.
class AnnouncedEndpoints {
 public:
  static constexpr std::size_t kMost = 32;
  /// Of one announcement; a larger one is not remembered.
  static constexpr std::size_t kMostOctets = 4096;
  /// Of memory for all of them; the newest stays in any case.
  static constexpr std::size_t kMaxMemory = 256 * 1024;

  /// An endpoint's request, with its texts.
  struct Announced {
    Announced(Action action, const spi::EndpointRequest& request);
    bool operator==(const Announced&) const = default;
    /// Of memory.
    std::size_t octets() const;

    Action action;
    std::string topic;
    PartitionNames partitions;
    spi::PropertyList data_tags;
  };
  using One = std::shared_ptr<const Announced>;

  void note(Action action, const spi::EndpointRequest& request);
  /// Those of that topic, newest first.
  std::vector<One> of_topic(Action action, std::string_view topic) const;

 private:
  mutable std::mutex mutex_;
  std::list<One> newest_first_;
  std::size_t octets_ = 0;  ///< of memory, of all in newest_first_
};

}  // namespace ddssec::access_control
