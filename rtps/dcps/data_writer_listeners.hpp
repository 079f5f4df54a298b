// Selects the listener for each status of a DataWriter (DDS 1.4, 2.2.4.3).
#pragma once

#include "rtps/dcps/listener.hpp"
#include "rtps/dcps/status_changes.hpp"

namespace ddssec::rtps {

/// Holds a DataWriter's own listener. A status that it does not handle goes to the publisher's
/// listener, then to the participant's.
class DataWriterListeners {
 public:
  /// Both must outlive this object.
  DataWriterListeners(const ListenerAndMask<PublisherListener>& of_publisher,
                      const ListenerAndMask<DomainParticipantListener>& of_participant)
      : of_publisher_(of_publisher), of_participant_(of_participant) {}

  // The caller holds the participant's lock:
  /// Returns true if there was one before.
  bool set(DataWriterListener* listener, StatusMask mask) { return own_.set(listener, mask); }
  /// Returns nullptr if there is none.
  DataWriterListener* for_status(StatusKind kind) const;

  /// Calls the listeners for the statuses in `changes`, which marks them as read. The caller does
  /// not hold the lock, which is `mutex`.
  void notify(AnyDataWriter& writer, const StatusChanges& changes, std::mutex& mutex) const;

 private:
  ListenerAndMask<DataWriterListener> own_;
  const ListenerAndMask<PublisherListener>& of_publisher_;
  const ListenerAndMask<DomainParticipantListener>& of_participant_;
};

}  // namespace ddssec::rtps
