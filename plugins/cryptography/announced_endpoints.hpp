// How much the participants of one certificate have announced. A host keeps every endpoint that is
// announced, matched or not, with all that its announcement says. Cyclone DDS sets no bound.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <unordered_map>

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

  /// Announcements that the host has acknowledged and that come again have a sum of their own: what
  /// a stranger repeats takes no room from what is new.
  enum class Heard : std::uint8_t { first, again };

  /// One announcement takes the place of another. False: that would be too much, and nothing
  /// changes.
  bool replace(std::size_t before, std::size_t after, Heard heard = Heard::first);
  std::size_t sum(Heard heard = Heard::first) const;

 private:
  mutable std::mutex mutex_;
  std::array<std::size_t, 2> sums_ = {};  ///< by Heard
};

/// Those of each subject (subject_of in engine.hpp) that has participants. Thread-safe.
class AnnouncementAccounts {
 public:
  std::shared_ptr<AnnouncedOctets> of(std::uint64_t subject);

 private:
  std::mutex mutex_;
  std::unordered_map<std::uint64_t, std::weak_ptr<AnnouncedOctets>> accounts_;
};

/// Numbers of samples that a writer said it does not have, or has no more.
class SkippedNumbers {
 public:
  /// From `begin` to before `end`.
  void add(std::uint64_t begin, std::uint64_t end);
  bool contains(std::uint64_t number) const;
  void forget_below(std::uint64_t number);

 private:
  /// Of further ones, what lies between two counts as skipped.
  static constexpr std::size_t kMost = 64;
  std::map<std::uint64_t, std::uint64_t> ranges_;  ///< begin and end; apart from one another
};

/// What one DATA, or one sample in fragments, says.
struct Announcement {
  enum class Kind : std::uint8_t {
    nothing,    ///< it has no payload that the host would read
    announces,  ///< an endpoint, for the first time or again
    ends,       ///< the endpoint is disposed or unregistered
    unread,     ///< its first fragment came, or more
  };
  std::uint64_t number = 0;  ///< writerSN
  Kind kind = Kind::nothing;
  EntityId entity = {};
  std::size_t octets = 0;  ///< of the payload; of a sample in fragments, of all
  bool operator==(const Announcement&) const = default;
};

/// What one participant has announced, and how much of it the host holds. Thread-safe.
///
/// The host passes over a sample whose number it has had, holds one back until those before it have
/// come, and drops some without a word. So whatever passes counts by its number, until the host has
/// acknowledged it. Only then does it take the place of what was said of its endpoint before, and
/// an end counts only if the host cannot have skipped it: nothing said that its number is skipped,
/// and all that passed under it was the same.
class AnnouncedEndpoints {
 public:
  AnnouncedEndpoints() = default;
  ~AnnouncedEndpoints();
  AnnouncedEndpoints(const AnnouncedEndpoints&) = delete;
  AnnouncedEndpoints& operator=(const AnnouncedEndpoints&) = delete;

  /// From now on they count for that account. Before that for one of their own.
  void count_for(std::shared_ptr<AnnouncedOctets> account);
  /// It may pass. Error: builtin_source_unreadable, if the certificate has no room for it, or if
  /// something else passed under its number; then nothing changes.
  Status note(const BuiltinTopic& topic, const Announcement& announcement);
  /// All fragments of an unread one have come, and announce that endpoint. Error as of note.
  Status complete(const BuiltinTopic& topic, const Announcement& announcement);
  /// No fragment of an unread one passed.
  void take_back(const BuiltinTopic& topic, std::uint64_t number);
  /// A GAP or HEARTBEAT said that there are no samples from `begin` to before `end`.
  void skip(const BuiltinTopic& topic, std::uint64_t begin, std::uint64_t end);
  /// The host has acknowledged all below `next`.
  void acknowledged(const BuiltinTopic& topic, std::uint64_t next);
  bool is_acknowledged(const BuiltinTopic& topic, std::uint64_t number) const;

 private:
  struct Writer {
    std::uint64_t next = 0;  ///< all below are acknowledged
    std::map<std::uint64_t, Announcement> passed = {};
    SkippedNumbers skipped = {};
    std::map<EntityId, std::size_t> endpoints = {};  ///< what the host holds of each
    /// What came of each under numbers that were acknowledged.
    std::map<EntityId, std::size_t> again = {};
  };
  static std::size_t cost_of(const Announcement& announcement);
  Status note_again(const BuiltinTopic& topic, Writer& writer, const Announcement& announcement);
  void settle(Writer& writer, const Announcement& announcement);
  void set(Writer& writer, const EntityId& entity, std::size_t cost);
  void forget(Writer& writer, const EntityId& entity);
  std::size_t sum() const;
  std::size_t sum_again() const;
  void leave_account();

  mutable std::mutex mutex_;
  std::shared_ptr<AnnouncedOctets> account_ = std::make_shared<AnnouncedOctets>();
  std::map<EntityId, Writer> writers_;  ///< as many as there are topics
};

}  // namespace ddssec::cryptography
