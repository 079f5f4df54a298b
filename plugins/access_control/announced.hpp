// What a peer's announcements asked for and were allowed.
#pragma once

#include <list>
#include <mutex>
#include <string>
#include <vector>

#include "governance/decision.hpp"
#include "plugins/spi/access_control.hpp"

namespace ddssec::access_control {

using governance::Action;

/// The host asks about a remote endpoint by its own partitions and tags, and about a match by those
/// of our endpoint: this is how the second question knows of the first. Bounded; the newest stay,
/// and the host asks the second right after the first. Thread-safe.
class AnnouncedEndpoints {
 public:
  static constexpr std::size_t kMost = 32;
  /// Of one announcement; a larger one is not remembered.
  static constexpr std::size_t kMostOctets = 4096;

  /// An endpoint's request, with its texts.
  struct Announced {
    Announced(Action action, const spi::EndpointRequest& request);
    bool operator==(const Announced&) const = default;
    std::vector<std::string_view> partition_views() const;

    Action action;
    std::string topic;
    std::vector<std::string> partitions;
    spi::PropertyList data_tags;
  };

  void note(Action action, const spi::EndpointRequest& request);
  /// Those of that topic that would match our endpoint by their partitions, newest first.
  std::vector<Announced> meeting(Action action, const spi::EndpointRequest& ours) const;

 private:
  mutable std::mutex mutex_;
  std::list<Announced> newest_first_;
};

}  // namespace ddssec::access_control
