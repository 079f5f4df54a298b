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

  void add(const Guid& writer, const GuidPrefix& identity, const Position& position) {
    static_cast<void>(take(writer));
    writers_[writer] = {position, identity, ++last_};
    of_[identity][last_] = writer;
    if (writers_.size() <= kMax) return;
    auto most = of_.begin();
    for (auto at = of_.begin(); at != of_.end(); ++at)
      if (at->second.size() > most->second.size()) most = at;
    static_cast<void>(take(Guid(most->second.begin()->second)));
  }
  /// Keys of the writer have come that revise the former ones: the position counts for both.
  /// Without an entity, the same for all writers of the participant.
  void note_revised(const Guid& writer, const KeysOf& keys_of) {
    each_of(writer.prefix, [&](const Guid& guid, Position& position) {
      if (!writer.entity.is_zero() && guid != writer) return;
      position.newest_next = {1};
      position.newest_heartbeat.reset();
      if (const auto keys = keys_of(guid)) position.keys = *keys;
    });
  }
  /// Former keys of the participant have ended, with which others may have sent in its name.
  void distrust_former_keys(const GuidPrefix& participant) {
    each_of(participant, [](const Guid&, Position& position) { position.is_doubted = true; });
  }
  /// Removes and returns the writer's position; empty if the writer is not known.
  std::optional<Position> take(const Guid& writer) {
    const auto at = writers_.find(writer);
    if (at == writers_.end()) return std::nullopt;
    const auto [position, identity, number] = at->second;
    writers_.erase(at);
    const auto share = of_.find(identity);
    share->second.erase(number);
    if (share->second.empty()) of_.erase(share);
    return position;
  }

 private:
  template <class F>
  void each_of(const GuidPrefix& participant, F&& f) {
    for (auto at = writers_.lower_bound({participant, {}}); at != writers_.end(); ++at) {
      if (at->first.prefix != participant) return;
      f(at->first, at->second.position);
    }
  }

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
