// How readers of the writer's own process get its samples.
#pragma once

#include "rtps/reliability/matched_readers.hpp"
#include "rtps/reliability/writer_history.hpp"
#include "rtps/reliability/writer_messages.hpp"

namespace ddssec::rtps {

/// They get the same history without messages, in the order of numbers, in the thread that
/// writes, takes or matches. What a reader refuses stays with the writer until it asks.
class LocalDelivery {
 public:
  /// `history` and `readers` outlive it.
  LocalDelivery(const Guid& writer, const WriterHistory& history, MatchedReaders& readers)
      : writer_(writer), history_(history), readers_(readers) {}

  /// Readers are told where the writer stands in the group, which outlives it.
  void join(const WriterGroup& group) { group_ = &group; }
  /// Offers an attached reader all that it has not taken.
  void feed(ReaderProxy& proxy);
  void feed_all();
  /// Tells all attached readers that the writer lives.
  void assert_liveliness();
  /// The writer ends.
  void detach_all();

 private:
  const Guid writer_;
  const WriterHistory& history_;
  MatchedReaders& readers_;
  const WriterGroup* group_ = nullptr;
};

}  // namespace ddssec::rtps
