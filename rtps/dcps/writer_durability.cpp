#include "rtps/dcps/writer_durability.hpp"

#include <algorithm>

#include "rtps/durability/durable_store.hpp"

namespace ddssec::rtps {
namespace {

// The pause between two steps: the store removes many samples in several steps.
constexpr MonotonicTime kMinPause = std::chrono::milliseconds(5);

}  // namespace

WriterDurability::~WriterDurability() {
  if (is_open()) store_->close_stream(stream_);
}

Result<WriterDurability::RestoredHistory> WriterDurability::open(DurableStore& store, StreamKey key,
                                                                 const DurabilityService& service,
                                                                 const Moment& now,
                                                                 Duration lifespan) {
  DDSSEC_ASSIGN_OR_RETURN(auto opened, store.open_stream(std::move(key), service, now, lifespan));
  lifespan_ = lifespan;
  store_ = &store;
  stream_ = opened.id;
  return RestoredHistory{std::move(opened.history), std::move(opened.expires)};
}

void WriterDurability::append(Change& change, const Guid& writer, SequenceNumber number,
                              const Moment& now) {
  if (!is_open()) return;
  change.original = {writer, number};
  store_->clean_up(stream_, now);
  store_->append({.stream = stream_, .change = change, .lifespan = lifespan_}, now);
  change.original = {};
}

void WriterDurability::clean_up(const Moment& now) {
  if (is_open()) store_->clean_up(stream_, now);
}

MonotonicTime WriterDurability::next_clean_up(MonotonicTime now) const {
  return is_open() ? std::max(store_->next_due(stream_), now + kMinPause) : kNever;
}

Status WriterDurability::wait_for_room(std::unique_lock<std::mutex>& lock,
                                       std::chrono::nanoseconds timeout) {
  if (!is_open()) return {};
  DDSSEC_RETURN_IF_ERROR(store_->status());
  if (!store_->is_behind()) return {};
  lock.unlock();
  auto room = store_->wait_for_room(timeout);
  lock.lock();
  return room;
}

Status WriterDurability::flush(std::chrono::nanoseconds timeout) {
  return is_open() ? store_->flush(timeout) : Status{};
}

}  // namespace ddssec::rtps
