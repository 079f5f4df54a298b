// PRESENTATION on the reading side (DDS 1.4, 2.2.3.6; RTPS 8.7.5 and 8.7.6): samples of a coherent
// set are held until all of it is there, samples of a group until those before them are. No I/O,
// clock or lock.
#pragma once

#include <map>
#include <set>
#include <vector>

#include "rtps/dcps/held_instances.hpp"
#include "rtps/reliability/stateful_writer.hpp"

namespace ddssec::rtps {

/// A reader whose samples a Presenter holds back.
class PresentedReader {
 public:
  /// Why a set is given up.
  enum class Limit : std::uint8_t {
    samples,     ///< the reader cannot hold so many samples, or octets, at once
    share,       ///< its identity has more in open sets than it may
    writer_end,  ///< its writer ended before the reader had room for it
  };

  virtual ~PresentedReader() = default;
  /// Whether so many samples with so many octets of payload can be stored.
  virtual Room room_for(std::size_t samples, std::size_t octets) const = 0;
  virtual void present(Change& change) = 0;
  /// Samples of a set that will never be whole.
  virtual void lose(std::size_t samples) = 0;
  /// Samples of a set of that writer that a limit ends.
  virtual void give_up(const Guid& writer, std::size_t samples, Limit limit) = 0;
};

/// Of one reader, or with GROUP scope of all readers of a subscriber.
class Presenter {
 public:
  /// What is held back of all writers together. No identity has more than is free, so that there
  /// is always room for another one. Of an identity that wants more, changes are refused for now
  /// while whole sets wait for the reader; otherwise its largest open sets are given up.
  static constexpr std::size_t kMostOctets = std::size_t{128} << 20;
  /// What each sample and each open set counts beside its payload.
  static constexpr std::size_t kPricePerItem = 1024;
  /// Sets of one publisher that not all of its writers ended; beyond, the oldest is given up.
  static constexpr std::size_t kMostSets = 1024;
  /// How long a hole among a group's numbers holds up what is behind it.
  static constexpr MonotonicTime kPatience = std::chrono::milliseconds(200);

  Presenter(bool by_group, bool coherent, bool ordered)
      : by_group_(by_group), coherent_(coherent), ordered_(ordered) {}

  /// `group`: the writer's publisher, if it said so. `identity`: whose share it takes.
  void add(PresentedReader& reader, const Guid& writer, const std::optional<Guid>& group,
           const GuidPrefix& identity);
  /// What is held of it and not whole, or finds no room, is lost.
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
  /// The price of everything that is held back.
  std::size_t octets() const { return octets_; }

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
    std::size_t octets = 0;  ///< the price of its items and of itself
  };
  /// Ready to be presented as soon as what is before it was.
  struct Batch {
    std::vector<Item> items;
    SequenceNumber last;  ///< group sequence number behind it
    MonotonicTime since{};
  };
  /// A publisher, or one writer of one reader.
  struct Source {
    GuidPrefix identity;
    std::map<StreamKey, Stream> streams;
    std::map<SequenceNumber, Set> sets;
    std::multimap<SequenceNumber, Batch> ready;
    SequenceNumber presented;  ///< group sequence number; 0 none yet
  };
  using SourceKey = std::pair<PresentedReader*, Guid>;
  /// What is held back of one identity.
  struct Held {
    std::size_t open = 0, ready = 0;
    std::size_t octets() const { return open + ready; }
  };
  /// What one reader gets of a batch.
  struct Wanted {
    std::size_t samples = 0, octets = 0;
    Guid writer;  ///< one of them
  };
  using WantedByReader = std::map<PresentedReader*, Wanted>;

  Source* find(PresentedReader& reader, const Guid& writer);
  static std::size_t price_of(const Item& item) {
    return kPricePerItem + item.change.payload.size();
  }
  /// It has its share: as much as is free.
  bool is_over(const Held& held) const { return octets_ + held.octets() >= kMostOctets; }
  void charge(const Source& source, Set& set, std::size_t price);
  void refund(const Source& source, Set& set, std::size_t price);
  void charge(const Source& source, const Batch& batch);
  void refund(const Source& source, std::size_t price);
  void forget_empty(std::map<GuidPrefix, Held>::iterator held);
  /// False: changes of that source are refused for now.
  bool make_room(const Source& source);
  void give_up_largest(const GuidPrefix& identity);
  void give_up(Batch& batch, const Source& source, const WantedByReader& wanted,
               PresentedReader::Limit limit);
  void gather(Source& source, const StreamKey& key, Change& change, MonotonicTime now);
  void end_set(Source& source, const StreamKey& key, SequenceNumber id, bool whole,
               MonotonicTime now);
  Set& set_of(Source& source, SequenceNumber id);
  void settle(Source& source, SequenceNumber id, MonotonicTime now);
  void hold(Source& source, Set& set, Item item);
  void drop(const Source& source, Set& set,
            std::optional<PresentedReader::Limit> limit = std::nullopt);
  void erase(Source& source, std::map<SequenceNumber, Set>::iterator at);
  void forget(Source& source, std::map<SequenceNumber, Set>::iterator at);
  void enqueue(Source& source, SequenceNumber at, Batch batch);
  void flush(Source& source);
  bool may_present(const Source& source, SequenceNumber first, const Batch& batch,
                   MonotonicTime now) const;
  static WantedByReader wanted_of(const Batch& batch);
  static Room room_for(const WantedByReader& wanted);
  static bool has_room(const Batch& batch) { return room_for(wanted_of(batch)) == Room::now; }
  void present(Source& source, Batch& batch);
  void release(Source& source, MonotonicTime now);

  const bool by_group_, coherent_, ordered_;
  bool paused_ = false;
  std::size_t octets_ = 0;  ///< of everything that is held back
  std::map<GuidPrefix, Held> held_;
  std::map<SourceKey, Source> sources_;
  std::map<StreamKey, SourceKey> source_of_;
};

}  // namespace ddssec::rtps
