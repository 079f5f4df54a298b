#include "rtps/dcps/writer_durability.hpp"

#include "rtps/durability/durable_store.hpp"

namespace ddssec::rtps {

WriterDurability::~WriterDurability() {
  if (is_open()) store_->close_stream(stream_);
}

Result<std::vector<Change>> WriterDurability::open(DurableStore& store, StreamKey key,
                                                   const DurabilityService& service, Time now) {
  DDSSEC_ASSIGN_OR_RETURN(auto opened, store.open_stream(std::move(key), service, now));
  store_ = &store;
  stream_ = opened.id;
  return std::move(opened.history);
}

void WriterDurability::append(Change& change, const Guid& writer, SequenceNumber number, Time now) {
  if (!is_open()) return;
  change.original = {writer, number};
  store_->append(stream_, change, now);
  change.original = {};
}

Status WriterDurability::wait_for_room(std::unique_lock<std::mutex>& lock,
                                       std::chrono::nanoseconds most) {
  if (!is_open()) return {};
  DDSSEC_RETURN_IF_ERROR(store_->status());
  if (!store_->is_behind()) return {};
  lock.unlock();
  auto room = store_->wait_for_room(most);
  lock.lock();
  return room;
}

Status WriterDurability::flush(std::chrono::nanoseconds most) {
  return is_open() ? store_->flush(most) : Status{};
}

}  // namespace ddssec::rtps
