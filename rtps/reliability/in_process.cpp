// Writers and readers of one process: the same histories without messages. A reader is fed in the
// order of numbers, in the thread of whoever writes, takes or matches; what it refuses stays with
// the writer until it asks again.
#include <algorithm>

#include "rtps/reliability/stateful_reader.hpp"

namespace ddssec::rtps {

void StatefulWriter::attach(StatefulReader& reader) {
  auto* proxy = find(reader.guid());
  if (proxy == nullptr || !proxy->reader.in_process || proxy->local != nullptr) return;
  if (!reader.attach(*this)) return;
  proxy->local = &reader;
  feed(reader.guid());
}

void StatefulWriter::detach(const Guid& reader) {
  if (auto* proxy = find(reader)) proxy->local = nullptr;
}

void StatefulWriter::lose(const Guid& reader) {
  detach(reader);
  unmatch(reader);
  if (on_acknowledged_) on_acknowledged_();
}

void StatefulWriter::feed(const Guid& reader) {
  auto* proxy = find(reader);
  if (proxy == nullptr || proxy->local == nullptr) return;
  feed(*proxy);
  release_acknowledged();
  if (on_acknowledged_) on_acknowledged_();
}

void StatefulWriter::feed(ReaderProxy& proxy) {
  if (held_back_) return;
  auto number = std::max(proxy.acknowledged.next(), history_.first());
  for (; number <= history_.last(); number = number.next()) {
    const auto* change = history_.find(number);
    const bool beyond = proxy.until.value != 0 && number >= proxy.until;
    if (change != nullptr && !beyond && !proxy.local->offer(*change)) break;
  }
  note_acknowledged(proxy, number.previous());
  proxy.local->skip(guid_, number);
  if (group_ != nullptr && number > history_.last()) proxy.local->pass(guid_, group_->current);
}

StatefulReader::~StatefulReader() {
  for (auto& [guid, proxy] : writers_)
    if (proxy.local() != nullptr) proxy.local()->lose(guid_);
}

bool StatefulReader::attach(StatefulWriter& writer) {
  auto* proxy = find(writer.guid());
  if (proxy == nullptr) return false;
  proxy->attach(writer, writer.history().last());
  return true;
}

void StatefulReader::detach(const Guid& writer) {
  if (auto* proxy = find(writer)) proxy->detach();
}

bool StatefulReader::offer(const Change& change) {
  if (alive_) alive_(change.writer);
  auto copy = change;
  return common_.deliver(copy) || !reliable_;
}

void StatefulReader::skip(const Guid& writer, SequenceNumber next) {
  if (auto* proxy = find(writer)) proxy->set_next(next);
}

}  // namespace ddssec::rtps
