// Delivers a writer's samples to readers of the same process.
#pragma once

#include "rtps/reliability/matched_readers.hpp"
#include "rtps/reliability/writer_history.hpp"
#include "rtps/reliability/writer_messages.hpp"

namespace ddssec::rtps {

/// These readers get the history without messages, in the order of sequence numbers, in the thread
/// that writes, takes or matches. A change that a reader refuses stays with the writer until the
/// reader requests it.
class LocalDelivery {
 public:
  /// `history` and `readers` must outlive this object.
  LocalDelivery(const Guid& writer, const WriterHistory& history, MatchedReaders& readers)
      : writer_(writer), history_(history), readers_(readers) {}

  /// Makes readers also get the writer's position in the group. `group` must outlive this object.
  void join(const WriterGroup& group) { group_ = &group; }
  /// Offers an attached reader all changes that it has not taken.
  void offer(ReaderProxy& proxy);
  void offer_to_all();
  /// Asserts the writer's liveliness to all attached readers.
  void assert_liveliness();
  /// Call it before the writer is destroyed.
  void detach_all();

 private:
  const Guid writer_;
  const WriterHistory& history_;
  MatchedReaders& readers_;
  const WriterGroup* group_ = nullptr;
};

}  // namespace ddssec::rtps
