// Limits how much the participants of one certificate may announce. A host stores every endpoint
// that is announced, matched or not, with its whole announcement. Cyclone DDS sets no limit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <unordered_map>

#include "base/ids.hpp"
#include "base/result.hpp"
#include "plugins/cryptography/builtin_names.hpp"
#include "plugins/cryptography/subject_id.hpp"

namespace ddssec::cryptography {

/// The account that the participants of one certificate share. Thread-safe.
class AnnouncedOctets {
 public:
  /// The limit in octets for all counted announcements, including kOfEach for each. It holds for
  /// each of the two sums below.
  static constexpr std::size_t kMax = std::size_t{64} << 20;
  /// The octets that the core stores for an endpoint besides its announcement, approximately.
  static constexpr std::size_t kOfEach = 1024;

  /// Announcements that come again after the host has acknowledged them are counted in a separate
  /// sum. So repetitions by an attacker take no space from new announcements.
  enum class Heard : std::uint8_t { first, again };

  /// Replaces an announcement of `before` octets by one of `after` octets. False if the sum would
  /// exceed the limit; then nothing changes.
  bool replace(std::size_t before, std::size_t after, Heard heard = Heard::first);
  std::size_t sum(Heard heard = Heard::first) const;

 private:
  mutable std::mutex mutex_;
  std::array<std::size_t, 2> sums_ = {};  ///< by Heard
};

/// The accounts of all subjects (subject_of in cryptography_state.hpp) that have participants.
/// Thread-safe.
class AnnouncementAccounts {
 public:
  std::shared_ptr<AnnouncedOctets> of(SubjectId subject);

 private:
  std::mutex mutex_;
  std::unordered_map<std::uint64_t, std::weak_ptr<AnnouncedOctets>> accounts_;
};

/// Sequence numbers of samples that a writer reported as missing or no longer available.
class SkippedNumbers {
 public:
  /// Adds `begin` up to but not including `end`.
  void add(std::uint64_t begin, std::uint64_t end);
  bool contains(std::uint64_t number) const;
  void forget_below(std::uint64_t number);

 private:
  /// The largest number of ranges. If there are more, the two lowest are joined, and the numbers
  /// between them count as skipped.
  static constexpr std::size_t kMax = 64;
  std::map<std::uint64_t, std::uint64_t> ranges_;  ///< begin and end; disjoint
};

/// The content of one DATA, or of one fragmented sample.
struct Announcement {
  enum class Kind : std::uint8_t {
    nothing,    ///< no payload that the host would read, or the end in a form it may refuse
    announces,  ///< it announces an endpoint, for the first time or again
    ends,       ///< it disposes or unregisters the endpoint, in a form that no host refuses
    unread,     ///< fragmented, and not all fragments have come
  };
  std::uint64_t number = 0;  ///< writerSN
  Kind kind = Kind::nothing;
  EntityId entity = {};
  std::size_t octets = 0;  ///< octets of the payload; for a fragmented sample, of all fragments
  bool hides = false;      ///< it does not say how the endpoint is protected
  bool operator==(const Announcement&) const = default;
};

/// The announcements of one participant, and how much of them the host stores. Thread-safe.
///
/// The host ignores a sample whose number it already had, delays one until those before it have
/// come, and drops some without notice. So every passed sample is counted under its number until
/// the host has acknowledged it. Only then does it replace the former announcement of its endpoint.
/// The end of an endpoint counts only if the host cannot have skipped it: nothing reported its
/// number as skipped, and everything that passed under this number was the same.
class AnnouncedEndpoints {
 public:
  static constexpr std::size_t kMaxEnded = 1024;

  AnnouncedEndpoints() = default;
  ~AnnouncedEndpoints();
  AnnouncedEndpoints(const AnnouncedEndpoints&) = delete;
  AnnouncedEndpoints& operator=(const AnnouncedEndpoints&) = delete;

  /// Counts later announcements for that account. Before, they count for a private one.
  void set_account(std::shared_ptr<AnnouncedOctets> account);
  /// Counts an announcement; success if it may pass to the host. Error: builtin_source_unreadable
  /// if the certificate's account is full, or if something else passed under this number before.
  /// Then nothing changes.
  Status note(const DiscoveryTopic& topic, const Announcement& announcement);
  /// Notes that all fragments of an unread announcement have come; `announcement` is its content.
  /// Errors as of note.
  Status complete(const DiscoveryTopic& topic, const Announcement& announcement);
  /// Removes an unread announcement of which no fragment passed.
  void retract(const DiscoveryTopic& topic, std::uint64_t number);
  /// Notes that a GAP or HEARTBEAT reported that there are no samples from `begin` up to but not
  /// including `end`.
  void skip(const DiscoveryTopic& topic, std::uint64_t begin, std::uint64_t end);
  /// Notes that the host has acknowledged all numbers below `next`.
  void acknowledged(const DiscoveryTopic& topic, std::uint64_t next);
  bool is_acknowledged(const DiscoveryTopic& topic, std::uint64_t number) const;

  /// Returns how many announcements of endpoints that were announced before, and have not ended,
  /// passed since the last call. Those that the host had already are not counted.
  std::size_t take_repeats();

  /// True if the participant has announced a writer, or a reader, without saying how that is
  /// protected. The host does not ask access control about such an endpoint, so no answer about
  /// another endpoint may count for it.
  bool hides_writers() const;
  bool hides_readers() const;
  /// True if the participant has announced that endpoint in the secure discovery, and not its end.
  bool has_secured(const EntityId& endpoint, bool is_writer) const;
  /// True if it has announced that endpoint in the secure discovery, and then its end, which the
  /// host has acknowledged. Of each kind the last kMaxEnded are known.
  bool has_ended(const EntityId& endpoint, bool is_writer) const;

 private:
  struct Writer {
    std::uint64_t next = 0;  ///< all numbers below are acknowledged
    /// True if one announcement does not say how its endpoint is protected.
    bool hides = false;
    std::map<std::uint64_t, Announcement> passed = {};
    SkippedNumbers skipped = {};
    std::map<EntityId, std::size_t> endpoints = {};  ///< octets that the host stores for each
    std::deque<EntityId> ended = {};                 ///< the last ones, at most kMaxEnded
    std::set<EntityId> announced = {};               ///< endpoints whose end is not acknowledged
    /// Octets that came for each endpoint under numbers that were already acknowledged.
    std::map<EntityId, std::size_t> again = {};
  };
  static std::size_t cost_of(const Announcement& announcement);
  Status note_again(const DiscoveryTopic& topic, Writer& writer, const Announcement& announcement);
  void note_announced(Writer& writer, const Announcement& announcement);
  void settle(Writer& writer, const Announcement& announcement);
  bool hides(const EntityId& writer) const;
  void set(Writer& writer, const EntityId& entity, std::size_t cost);
  void forget(Writer& writer, const EntityId& entity);
  std::size_t sum() const;
  std::size_t sum_again() const;
  void leave_account();

  mutable std::mutex mutex_;
  std::shared_ptr<AnnouncedOctets> account_ = std::make_shared<AnnouncedOctets>();
  std::map<EntityId, Writer> writers_;  ///< at most one for each topic
  std::size_t repeats_ = 0;
};

}  // namespace ddssec::cryptography
