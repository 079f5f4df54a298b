// PRESENTATION on the reading side (DDS 1.4, 2.2.3.6; RTPS 8.7.5 and 8.7.6): samples of a coherent
// set are held until all of it is there, samples of a group until those before them are. No I/O,
// clock or lock.
#pragma once

#include <map>
#include <set>
#include <vector>

#include "rtps/reliability/stateful_writer.hpp"

namespace ddssec::rtps {

/// A reader whose samples a Presenter holds back.
class PresentedReader {
 public:
  virtual ~PresentedReader() = default;
  /// True if so many samples can be stored.
  virtual bool has_room(std::size_t samples) const = 0;
  virtual void present(Change& change) = 0;
  /// Samples of a set that will never be whole.
  virtual void lose(std::size_t samples) = 0;
};

/// Of one reader, or with GROUP scope of all readers of a subscriber.
class Presenter {
 public:
  /// Samples held back of one writer or publisher; beyond, changes are refused for now, and a set
  /// that is larger is given up.
  static constexpr std::size_t kMostHeld = 65536;
  static constexpr std::size_t kMostOctets = std::size_t{64} << 20;
  /// Sets of one publisher that not all of its writers ended; beyond, the oldest is given up.
  static constexpr std::size_t kMostSets = 1024;
  /// How long a hole among a group's numbers holds up what is behind it.
  static constexpr MonotonicTime kPatience = std::chrono::milliseconds(200);

  Presenter(bool by_group, bool coherent, bool ordered)
      : by_group_(by_group), coherent_(coherent), ordered_(ordered) {}

  /// `group`: the writer's publisher, if it said so.
  void add(PresentedReader& reader, const Guid& writer, const std::optional<Guid>& group);
  /// What is held of it and not whole is lost.
  void remove(PresentedReader& reader, const Guid& writer, MonotonicTime now);
  void remove(PresentedReader& reader, MonotonicTime now);

  /// A reader's next change of a writer. False: refused for now.
  bool on_change(PresentedReader& reader, Change& change, MonotonicTime now);
  /// The writer has nothing up to this group sequence number that it has not delivered.
  void on_progress(PresentedReader& reader, const Guid& writer, SequenceNumber group,
                   MonotonicTime now);
  /// While paused nothing is presented (begin_access).
  void pause(bool paused, MonotonicTime now);
  /// Readers may have room again, or a hole was waited for long enough.
  void release(MonotonicTime now);
  MonotonicTime next_tick() const;

 private:
  using StreamKey = std::pair<PresentedReader*, Guid>;
  struct Item {
    PresentedReader* reader;
    Change change;
  };
  /// What one writer sends to one reader.
  struct Stream {
    SequenceNumber last;      ///< change; 0 none yet
    SequenceNumber set;       ///< that is open; 0 none
    SequenceNumber progress;  ///< group sequence number
  };
  struct Set {
    std::vector<Item> items;
    std::set<StreamKey> ended;
    bool broken = false;
  };
  /// Ready to be presented as soon as what is before it was.
  struct Batch {
    std::vector<Item> items;
    SequenceNumber last;  ///< group sequence number behind it
    MonotonicTime since{};
  };
  /// A publisher, or one writer of one reader.
  struct Source {
    std::map<StreamKey, Stream> streams;
    std::map<SequenceNumber, Set> sets;
    std::map<SequenceNumber, Batch> ready;
    SequenceNumber presented;  ///< group sequence number; 0 none yet
    std::size_t held = 0, octets = 0;
  };
  using SourceKey = std::pair<PresentedReader*, Guid>;

  Source* find(PresentedReader& reader, const Guid& writer);
  bool is_full(const Source& source) const {
    return source.held >= kMostHeld || source.octets >= kMostOctets;
  }
  void gather(Source& source, const StreamKey& key, Change& change, MonotonicTime now);
  void end_set(Source& source, const StreamKey& key, SequenceNumber id, bool whole,
               MonotonicTime now);
  Set& set_of(Source& source, SequenceNumber id);
  void settle(Source& source, SequenceNumber id, MonotonicTime now);
  void drop(Source& source, Set& set);
  void enqueue(Source& source, SequenceNumber at, Batch batch);
  bool may_present(const Source& source, SequenceNumber first, const Batch& batch,
                   MonotonicTime now) const;
  static bool has_room(const Batch& batch);
  void present(Source& source, Batch& batch);
  void release(Source& source, MonotonicTime now);

  const bool by_group_, coherent_, ordered_;
  bool paused_ = false;
  std::map<SourceKey, Source> sources_;
  std::map<StreamKey, SourceKey> source_of_;
};

}  // namespace ddssec::rtps
