// PRESENTATION on the reading side (DDS 1.4, 2.2.3.6; RTPS 8.7.5 and 8.7.6). Samples of a coherent
// set are held until the set is complete. Samples of a group are held until the samples before them
// have arrived. No I/O, clock or lock.
#pragma once

#include <map>
#include <set>
#include <vector>

#include "rtps/dcps/held_instances.hpp"
#include "rtps/reliability/change.hpp"

namespace ddssec::rtps {

/// A reader whose samples a Presenter holds back.
class PresentedReader {
 public:
  /// The reason why a set is given up.
  enum class Limit : std::uint8_t {
    samples,  ///< the reader cannot hold so many samples or octets at once
    share,    ///< its identity exceeds its share for open sets
  };

  virtual ~PresentedReader() = default;
  /// Returns the instance of a change; the default value if it has no key, or a key that cannot be
  /// read.
  virtual KeyHash instance_of(const Change& change) const = 0;
  /// Returns whether all of this can be stored. `writer` is one of the writers, which all have the
  /// same identity.
  virtual Room room_for(const WantedRoom& wanted, const Guid& writer) const = 0;
  /// Stores the change. Returns false if there is no room for it after all. The change is then
  /// unchanged.
  virtual bool present(Change& change) = 0;
  /// Notes that a writer has left: it was removed while its samples waited for room, and the last
  /// of them was presented.
  virtual void note_left(const Guid& writer) = 0;
  /// Reports samples of a set that will never be complete.
  virtual void note_lost(std::size_t samples) = 0;
  /// Reports samples of a set of that writer that is given up because of a limit.
  virtual void give_up(const Guid& writer, std::size_t samples, Limit limit) = 0;
};

/// Holds samples back for one reader, or with GROUP scope for all readers of a subscriber.
class Presenter {
 public:
  /// The limit for everything that is held, of all writers together. No identity may hold more than
  /// is still free, so that there is always room for another identity. If an identity exceeds its
  /// share, its changes are refused for now while complete sets wait for the reader. Otherwise its
  /// largest open sets are given up.
  static constexpr std::size_t kMaxOctets = std::size_t{128} << 20;
  /// The price of each sample and each open set, in addition to its payload.
  static constexpr std::size_t kPricePerItem = 1024;
  /// The largest number of sets of one publisher that not all of its writers have ended. If there
  /// are more, the oldest set is given up.
  static constexpr std::size_t kMaxSets = 1024;
  /// How long a gap in a group's sequence numbers delays the samples after it.
  static constexpr MonotonicTime kGapTimeout = std::chrono::milliseconds(200);

  /// A search for room costs time for each item of a batch. After unsuccessful searches for
  /// kItemsBeforePause items, the Presenter does not search for kPausePerItem for each of them. So
  /// waiting batches cost little of the reader's time, however often samples are taken.
  static constexpr std::size_t kItemsBeforePause = 256;
  static constexpr MonotonicTime kPausePerItem = std::chrono::microseconds(4);

  /// What the PRESENTATION policy asks for.
  struct PresentedAccess {
    bool is_by_group = false;  ///< GROUP scope: one publisher's writers are presented together
    bool is_coherent = false;
    bool is_ordered = false;
  };
  explicit Presenter(const PresentedAccess& access) : access_(access) {}

  /// `group` is the writer's publisher, if it was announced. `identity` is the identity whose share
  /// the writer uses.
  void add_writer(PresentedReader& reader, const Guid& writer, const std::optional<Guid>& group,
                  const GuidPrefix& identity);
  /// Removes the writer. Its samples in incomplete sets are lost. Others still wait for room,
  /// because the writer was told that they have arrived: then this returns true, and the reader is
  /// told when the writer has left.
  bool remove_writer(PresentedReader& reader, const Guid& writer, MonotonicTime now);
  void remove_reader(PresentedReader& reader, MonotonicTime now);

  /// Takes the next change of a writer for a reader. Returns false if the change is refused for
  /// now.
  bool on_change(PresentedReader& reader, Change& change, MonotonicTime now);
  /// Notes that the writer has delivered everything that it has up to this group sequence number.
  void on_progress(PresentedReader& reader, const Guid& writer, SequenceNumber group,
                   MonotonicTime now);
  /// Pauses or resumes. While paused, nothing is presented (begin_access).
  void pause(bool paused, MonotonicTime now);
  /// Whether readers may have room again since the last call.
  enum class ReaderRoom : std::uint8_t { may_be_freed, unchanged };
  /// Presents what has room now. Call it when readers may have room again, and at `next_tick`.
  void present_ready(MonotonicTime now, ReaderRoom room = ReaderRoom::may_be_freed);
  MonotonicTime next_tick() const;
  /// Returns the price of everything that is held.
  std::size_t octets() const { return octets_; }

 private:
  using StreamKey = std::pair<PresentedReader*, Guid>;
  using SourceKey = std::pair<PresentedReader*, Guid>;
  struct Item {
    PresentedReader* reader;
    Change change;
  };
  /// The changes that one writer sends to one reader.
  struct Stream {
    SequenceNumber last;      ///< number of the last change; 0 if there is none yet
    SequenceNumber set;       ///< the open set; 0 if there is none
    SequenceNumber progress;  ///< group sequence number
  };
  /// The room that one reader needs for its items of a batch.
  struct NeededRoom {
    WantedRoom room;
    Guid writer;  ///< one of the writers
  };
  struct Set {
    std::vector<Item> items;
    std::set<StreamKey> ended;
    bool is_broken = false;
    std::size_t octets = 0;  ///< the price of its items and of the set itself
  };
  /// Samples that can be presented as soon as everything before them has been presented.
  struct Batch {
    std::vector<Item> items;
    SequenceNumber last;  ///< last group sequence number in the batch
    MonotonicTime since{};
    std::map<PresentedReader*, NeededRoom> wanted = {};
    bool is_blocked = false;  ///< true if no room was found for it
    bool retries = false;     ///< true if readers have taken samples since
  };
  /// A publisher, or one writer of one reader.
  struct Source {
    SourceKey key;
    GuidPrefix identity;
    std::map<StreamKey, Stream> streams;
    std::map<SequenceNumber, Set> sets;
    std::multimap<SequenceNumber, Batch> ready;
    SequenceNumber presented;  ///< group sequence number; 0 if there is none yet
    /// Removed writers, with the number of their items in `ready`. The source is removed after the
    /// last of them.
    std::map<StreamKey, std::size_t> leaving;
  };
  /// The octets that are held of one identity.
  struct IdentityOctets {
    std::size_t open = 0, ready = 0;
    std::size_t octets() const { return open + ready; }
  };

  Source* find(PresentedReader& reader, const Guid& writer);
  static std::size_t price_of(const Item& item) {
    return kPricePerItem + item.change.payload.size();
  }
  /// True if the identity has used its share, which is as much as is still free.
  bool is_over(const IdentityOctets& held) const { return octets_ + held.octets() >= kMaxOctets; }
  void charge_open(const Source& source, Set& set, std::size_t price);
  void refund_open(const Source& source, Set& set, std::size_t price);
  void charge_ready(const Source& source, const Batch& batch);
  void refund_ready(const Source& source, std::size_t price);
  void forget_empty(std::map<GuidPrefix, IdentityOctets>::iterator held);
  /// Returns false if changes of that source are refused for now.
  bool make_room(const Source& source);
  void give_up_largest(const GuidPrefix& identity);
  void give_up_batch(Batch& batch, const Source& source, PresentedReader::Limit limit);
  void add_to_set(Source& source, const StreamKey& key, Change& change, MonotonicTime now);
  enum class SetEnd : std::uint8_t { whole, with_gap };
  void end_set(Source& source, const StreamKey& key, SequenceNumber id, SetEnd end,
               MonotonicTime now);
  Set& set_of(Source& source, SequenceNumber id);
  void finish_if_complete(Source& source, SequenceNumber id, MonotonicTime now);
  void add_item(Source& source, Set& set, Item item);
  void lose_items(const Source& source, Set& set,
                  std::optional<PresentedReader::Limit> limit = std::nullopt);
  void remove_set(Source& source, std::map<SequenceNumber, Set>::iterator at);
  void give_up_set(Source& source, std::map<SequenceNumber, Set>::iterator at);
  void enqueue(Source& source, SequenceNumber at, Batch batch);
  bool starts_leaving(Source& source, const StreamKey& key);
  void note_presented(Source& source, const StreamKey& key);
  std::map<SourceKey, Source>::iterator forget_if_done(std::map<SourceKey, Source>::iterator at);
  bool may_present(const Source& source, SequenceNumber first, const Batch& batch,
                   MonotonicTime now) const;
  static void note_wanted(Batch& batch);
  static Room room_for(const Batch& batch);
  void unblock(Batch& batch, MonotonicTime now, ReaderRoom room);
  bool present_batch(Source& source, Batch& batch);
  void present_ready_of(Source& source, MonotonicTime now);

  const PresentedAccess access_;
  bool is_paused_ = false;
  MonotonicTime search_at_{};  ///< before this time, no room is searched for blocked batches
  bool retries_ = false;       ///< true if a batch waits for search_at_
  std::size_t in_vain_ = 0;    ///< items of the unsuccessful searches since the last pause
  SourceKey searched_;         ///< source of the batch that was searched last
  std::size_t octets_ = 0;     ///< octets of everything that is held
  std::map<GuidPrefix, IdentityOctets> held_;
  std::map<SourceKey, Source> sources_;
  std::map<StreamKey, SourceKey> source_of_;
};

}  // namespace ddssec::rtps
