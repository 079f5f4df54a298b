// The types that the parts of a store of samples exchange.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/ids.hpp"
#include "rtps/reliability/change.hpp"

namespace ddssec::rtps {

/// Identifies samples that belong together: those of one writer, before and after it was restarted.
struct StreamKey {
  std::uint32_t domain = 0;
  std::string topic, type;
  std::vector<std::string> partition = {};
  /// Everything else that determines which readers may get the samples, such as the domain tag.
  std::vector<std::string> scope = {};
  /// Distinguishes writers of the participant for which all other members are equal.
  std::uint32_t ordinal = 0;
  bool operator==(const StreamKey&) const = default;
};

/// Identifies a stream in one opened store.
struct StreamId {
  std::int64_t value = 0;
  auto operator<=>(const StreamId&) const = default;
};

/// LIFESPAN (DDS 1.4, 2.2.3.16) of a stored sample, in nanoseconds. It is for the next process:
/// while a process runs, its monotonic clock decides.
struct StoredExpiry {
  std::int64_t at;        ///< calendar time
  std::int64_t lifespan;  ///< greater than 0; the longest time left when a store is opened
  bool operator==(const StoredExpiry&) const = default;
};

/// Says what decides whether a relayed change, which its original writer did not send itself, is
/// newer than the stored samples of its instance. Between different writers, source timestamps
/// always decide.
enum class RelayOrder : std::uint8_t {
  direct,       ///< its original writer sent it: the order of arrival decides
  number,       ///< the sequence numbers of its original writer
  source_time,  ///< source timestamps (DESTINATION_ORDER BY_SOURCE_TIMESTAMP)
};

/// An instance of which nothing is stored because it has ended.
struct StoredEnd {
  std::array<std::uint8_t, 16> instance = {};  ///< a digest of its key
  Time time = {};                              ///< source timestamp of its end
  bool is_forgotten = false;
};

/// The work of a commit for one change.
struct StoredChange {
  StreamId stream = {};
  Change change = {};
  /// The identity whose share of the store it uses (ParticipantCore::identity_of). If it is empty,
  /// no limit applies.
  std::optional<GuidPrefix> identity = {};
  /// True if the change has waited for room. Source timestamps then decide between it and what
  /// another identity wrote to its instance. They count for late changes only: otherwise a
  /// timestamp from the future, or a clock that is behind, would exclude a writer.
  bool is_late = false;
  /// True if the store remembers that it has this change of its original writer, stored or not.
  bool is_remembered = false;
  RelayOrder relay_order = RelayOrder::direct;
  /// The LIFESPAN of its writer. A sample that has expired is not stored.
  Duration lifespan = kDurationInfinite;
  std::int64_t row = 0;                     ///< the row in which it is stored; 0 if there is none
  std::optional<StoredExpiry> expiry = {};  ///< follows from its source timestamp and lifespan
  std::vector<std::int64_t> removed = {};   ///< rows that are removed
  /// The changes to the entries of instances that have ended.
  std::vector<StoredEnd> ends = {};
};

/// The last change of a writer that was heard, and its source timestamp.
struct HeardWriter {
  Guid writer;
  SequenceNumber number;
  Time time;
};

/// The samples of a stream. The first four lists have the same length.
struct StoredHistory {
  std::vector<Change> changes;
  std::vector<std::int64_t> rows;
  std::vector<std::optional<GuidPrefix>> identities;
  std::vector<std::optional<StoredExpiry>> expiries;
  std::vector<HeardWriter> heard;
  std::vector<StoredEnd> ends = {};
};

}  // namespace ddssec::rtps
