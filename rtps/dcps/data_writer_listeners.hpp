// Which listener hears of a DataWriter's statuses (DDS 1.4, 2.2.4.3).
#pragma once

#include "rtps/dcps/listener.hpp"
#include "rtps/dcps/status_changes.hpp"

namespace ddssec::rtps {

/// A DataWriter's own listener; what it is not for goes to the publisher's, then to the
/// participant's.
class DataWriterListeners {
 public:
  /// Both outlive it.
  DataWriterListeners(const Listening<PublisherListener>& of_publisher,
                      const Listening<DomainParticipantListener>& of_participant)
      : of_publisher_(of_publisher), of_participant_(of_participant) {}

  // With the participant's lock held:
  void set(DataWriterListener* listener, StatusMask mask) { own_ = {listener, mask}; }
  /// nullptr if there is none.
  DataWriterListener* for_status(StatusKind kind) const;

  /// Without the lock, which is `mutex`: calls the listeners for the statuses in `changes`, which
  /// become read by that.
  void tell(AnyDataWriter& writer, const StatusChanges& changes, std::mutex& mutex) const;

 private:
  Listening<DataWriterListener> own_;
  const Listening<PublisherListener>& of_publisher_;
  const Listening<DomainParticipantListener>& of_participant_;
};

}  // namespace ddssec::rtps
