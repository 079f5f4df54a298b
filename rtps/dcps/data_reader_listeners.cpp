#include "rtps/dcps/data_reader_listeners.hpp"

#include "rtps/dcps/subscriber.hpp"

namespace ddssec::rtps {

DataReaderListener* DataReaderListeners::for_status(StatusKind kind) const {
  if (auto* own = own_.for_status(kind)) return own;
  if (auto* group = of_subscriber_.for_status(kind)) return group;
  return of_participant_.for_status(kind);
}

SubscriberListener* DataReaderListeners::for_data_on_readers() const {
  if (auto* group = of_subscriber_.for_status(StatusKind::data_on_readers)) return group;
  return of_participant_.for_status(StatusKind::data_on_readers);
}

bool DataReaderListeners::has(StatusKind kind) const {
  return for_status(kind) != nullptr ||
         (kind == StatusKind::data_available && for_data_on_readers() != nullptr);
}

void DataReaderListeners::notify(AnyDataReader& reader, const Changes& changes) const {
  const auto listener = [&](StatusKind kind) {
    const std::lock_guard held(changes.mutex);
    return changes.of_reader.contains(kind) ? for_status(kind) : nullptr;
  };
  if (auto* l = listener(StatusKind::subscription_matched))
    l->on_subscription_matched(reader, reader.subscription_matched_status());
  if (auto* l = listener(StatusKind::requested_incompatible_qos))
    l->on_requested_incompatible_qos(reader, reader.requested_incompatible_qos_status());
  if (auto* l = listener(StatusKind::liveliness_changed))
    l->on_liveliness_changed(reader, reader.liveliness_changed_status());
  if (auto* l = listener(StatusKind::requested_deadline_missed))
    l->on_requested_deadline_missed(reader, reader.requested_deadline_missed_status());
  if (auto* l = listener(StatusKind::sample_lost))
    l->on_sample_lost(reader, reader.sample_lost_status());
  if (auto* l = listener(StatusKind::sample_rejected))
    l->on_sample_rejected(reader, reader.sample_rejected_status());
  notify_of_data(reader, changes);
}

void DataReaderListeners::notify_of_data(AnyDataReader& reader, const Changes& changes) const {
  SubscriberListener* of_readers = nullptr;
  DataReaderListener* of_data = nullptr;
  {
    const std::lock_guard held(changes.mutex);
    if (!changes.of_reader.contains(StatusKind::data_available)) return;
    of_readers = for_data_on_readers();
    if (of_readers == nullptr) of_data = for_status(StatusKind::data_available);
    if (of_data != nullptr) changes.of_reader.clear(StatusKind::data_available);
    changes.of_subscriber.clear(StatusKind::data_on_readers);
  }
  if (of_readers != nullptr) of_readers->on_data_on_readers(reader.subscriber());
  if (of_data != nullptr) of_data->on_data_available(reader);
}

void DataReaderListeners::notify_of_data_available(AnyDataReader& reader,
                                                   const Changes& changes) const {
  DataReaderListener* listener = nullptr;
  {
    const std::lock_guard held(changes.mutex);
    listener = for_status(StatusKind::data_available);
    if (listener != nullptr) changes.of_reader.clear(StatusKind::data_available);
  }
  if (listener != nullptr) listener->on_data_available(reader);
}

}  // namespace ddssec::rtps
