#include "rtps/dcps/data_writer_listeners.hpp"

#include "rtps/dcps/data_writer.hpp"

namespace ddssec::rtps {

DataWriterListener* DataWriterListeners::for_status(StatusKind kind) const {
  if (auto* own = own_.for_status(kind)) return own;
  if (auto* group = of_publisher_.for_status(kind)) return group;
  return of_participant_.for_status(kind);
}

void DataWriterListeners::notify(AnyDataWriter& writer, const StatusChanges& changes,
                                 std::mutex& mutex) const {
  const auto listener = [&](StatusKind kind) {
    const std::lock_guard held(mutex);
    return changes.contains(kind) ? for_status(kind) : nullptr;
  };
  if (auto* l = listener(StatusKind::publication_matched))
    l->on_publication_matched(writer, writer.publication_matched_status());
  if (auto* l = listener(StatusKind::offered_incompatible_qos))
    l->on_offered_incompatible_qos(writer, writer.offered_incompatible_qos_status());
  if (auto* l = listener(StatusKind::offered_deadline_missed))
    l->on_offered_deadline_missed(writer, writer.offered_deadline_missed_status());
  if (auto* l = listener(StatusKind::liveliness_lost))
    l->on_liveliness_lost(writer, writer.liveliness_lost_status());
}

}  // namespace ddssec::rtps
