// How much the participants of one certificate have announced. A host keeps every endpoint that is
// announced, matched or not, with all that its announcement says. Cyclone DDS sets no bound.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <utility>

#include "base/ids.hpp"
#include "base/result.hpp"
#include "plugins/cryptography/builtin_names.hpp"

namespace ddssec::cryptography {

/// What the participants of one certificate share. Thread-safe.
class AnnouncedOctets {
 public:
  /// Of all announcements that count, with kOfEach for each.
  static constexpr std::size_t kMost = std::size_t{64} << 20;
  /// What the core keeps of an endpoint whatever is announced of it, roughly.
  static constexpr std::size_t kOfEach = 1024;

  /// One announcement takes the place of another. False: that would be too much, and nothing
  /// changes.
  bool replace(std::size_t before, std::size_t after);
  std::size_t sum() const;

 private:
  mutable std::mutex mutex_;
  std::size_t sum_ = 0;
};

/// Those of each subject (subject_of in engine.hpp) that has participants. Thread-safe.
class AnnouncementAccounts {
 public:
  std::shared_ptr<AnnouncedOctets> of(std::uint64_t subject);

 private:
  std::mutex mutex_;
  std::unordered_map<std::uint64_t, std::weak_ptr<AnnouncedOctets>> accounts_;
};

/// The endpoints that one participant has announced. Thread-safe.
class AnnouncedEndpoints {
 public:
  AnnouncedEndpoints() = default;
  ~AnnouncedEndpoints();
  AnnouncedEndpoints(const AnnouncedEndpoints&) = delete;
  AnnouncedEndpoints& operator=(const AnnouncedEndpoints&) = delete;

  /// From now on they count for that account. Before that for one of their own.
  void count_for(std::shared_ptr<AnnouncedOctets> account);
  /// A whole announcement of so many octets, for the first time or again. Error:
  /// builtin_source_unreadable, and the former one goes on counting.
  Status announce(const BuiltinTopic& topic, const EntityId& entity, std::size_t octets);
  /// The endpoint is disposed or unregistered.
  void withdraw(const BuiltinTopic& topic, const EntityId& entity);

 private:
  using Key = std::pair<EntityId, EntityId>;  ///< writer of the announcement, endpoint
  void clear();

  std::mutex mutex_;
  std::shared_ptr<AnnouncedOctets> account_ = std::make_shared<AnnouncedOctets>();
  std::map<Key, std::size_t> sizes_;
};

}  // namespace ddssec::cryptography
