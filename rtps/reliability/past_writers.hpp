// Writers that left a reader, with the keys with which they may return.
#pragma once

#include <functional>
#include <map>
#include <optional>

#include "base/hash.hpp"
#include "base/ids.hpp"
#include "wire/numbers.hpp"

namespace ddssec::rtps {

/// Remembers these writers' positions: what a writer sent before it left does not count as new when
/// it returns. If there is no room, the identity with the most writers loses its oldest.
class PastWriters {
 public:
  static constexpr std::size_t kMax = 1024;
  struct Position {
    Sha256Digest keys;
    SequenceNumber next;  ///< every change below was delivered or given up
    std::int32_t last_heartbeat;
    /// As `next`, but moved only by messages under the newest keys. Participants that have only
    /// former keys cannot have moved it.
    SequenceNumber newest_next = {1};
    std::optional<std::int32_t> newest_heartbeat = {};
    /// Others may have moved `next` and `last_heartbeat`, with keys that have ended.
    bool is_doubted = false;
  };
  /// Returns the digest of the writer's present keys; empty if they are not known.
  using KeysOf = std::function<std::optional<Sha256Digest>(const Guid& writer)>;

  /// Adds a writer that has left, or replaces its position.
  void add(const Guid& writer, const GuidPrefix& identity, const Position& position);
  /// Call it when the writer has revised its keys. The position stays valid under the new keys. If
  /// `writer` has no entity, this is for all writers of the participant.
  void note_revised(const Guid& writer, const KeysOf& keys_of);
  /// Notes that former keys of the participant have ended, with which others may have sent in its
  /// name.
  void distrust_former_keys(const GuidPrefix& participant);
  /// Removes and returns the writer's position; empty if the writer is not known.
  std::optional<Position> take(const Guid& writer);

 private:
  template <class F>
  void each_of(const GuidPrefix& participant, F&& f);

  struct Entry {
    Position position;
    GuidPrefix identity;
    std::uint64_t number = 0;  ///< position in the order in which they left
  };
  std::map<Guid, Entry> writers_;
  std::map<GuidPrefix, std::map<std::uint64_t, Guid>> of_;
  std::uint64_t last_ = 0;
};

}  // namespace ddssec::rtps
