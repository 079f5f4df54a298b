// Announces the end of local readers in a way that peers trust.
//
// Cyclone DDS 0.10.2 announces a reader with protected discovery by the protected writer of
// subscriptions. When the reader is deleted, it has forgotten how it was protected. So it announces
// the end by the unprotected writer, outside of any protection, and ddssec peers do not trust that
// (closed_readers.hpp).
//
// So the end is announced here, in the protected stream. A further reader of the host, the carrier,
// makes the host announce something there. That announcement is replaced by one that ends another
// reader, which the carrier's USER_DATA names. The host retransmits it to each peer that lacks it,
// like any announcement.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "wire/data_frag.hpp"

namespace ddssec::cyclonedds {

/// The topic of carriers. Peers never receive it.
inline constexpr std::string_view kCarrierTopic = "ddssec_end_of_reader";

/// The entities of one participant, by their keys, in one bit each: at most 2 MiB. The host gives
/// keys in ascending order, to entities of every kind.
class EntityKeys {
 public:
  void insert(const EntityId& entity);
  bool contains(const EntityId& entity) const;

 private:
  std::vector<bool> has_;
};

/// The readers that participants of one domain of this process announced by their protected writers
/// of subscriptions. Thread-safe.
class OwnReaders {
 public:
  /// Buffer for a replacement submessage.
  using Room = std::array<std::uint8_t, 128>;

  /// Returns the submessage to send in place of `submessage` of a local writer, before protection:
  /// either the same, or one that was written into `room`. `sender` is the writer's handle.
  BytesView said(std::int64_t sender, BytesView submessage, Room& room);

  /// Returns the readers whose end was not announced yet.
  std::vector<Guid> announced() const;
  /// Returns the number of readers announced so far, each counted once.
  std::uint64_t count() const;
  /// Notes that a carrier was created for that reader.
  void note_ended(const Guid& reader);
  /// Forgets a participant of this process that has ended.
  void forget(const GuidPrefix& participant);

 private:
  /// One announcement of a reader, or its end.
  struct Announcement;
  /// The fragments of an announcement that were sent so far.
  struct BegunAnnouncement {
    rtps::SequenceNumber number{1};
    std::uint32_t next = 1;  ///< the number of the next fragment
    Bytes octets = {};
  };
  static constexpr std::size_t kMaxBegun = 16, kMaxBegunOctets = std::size_t{1} << 18;

  std::optional<Announcement> read(std::int64_t sender, BytesView submessage);
  std::optional<Announcement> read(std::int64_t sender, const rtps::DataFrag& piece);
  void note(const Announcement& announcement);
  void note_end(const Guid& reader);
  bool has_ended(const Guid& reader) const;

  mutable std::mutex mutex_;
  std::set<Guid> announced_;
  std::map<std::int64_t, BegunAnnouncement> begun_;  ///< by sender
  /// The host never drops the announcement of a deleted reader: it repeats all to a participant
  /// that joins later. None may therefore be forgotten here while its owner lives, because its end
  /// would be carried again.
  std::map<GuidPrefix, EntityKeys> ended_;
  std::uint64_t count_ = 0;
};

}  // namespace ddssec::cyclonedds
