// Which listener hears of a DataReader's statuses (DDS 1.4, 2.2.4.3).
#pragma once

#include "rtps/dcps/listener.hpp"
#include "rtps/dcps/status_changes.hpp"

namespace ddssec::rtps {

/// A DataReader's own listener; what it is not for goes to the subscriber's, then to the
/// participant's.
class DataReaderListeners {
 public:
  /// Both outlive it.
  DataReaderListeners(const Listening<SubscriberListener>& of_subscriber,
                      const Listening<DomainParticipantListener>& of_participant)
      : of_subscriber_(of_subscriber), of_participant_(of_participant) {}

  // With the participant's lock held:
  void set(DataReaderListener* listener, StatusMask mask) { own_ = {listener, mask}; }
  /// nullptr if there is none.
  DataReaderListener* for_status(StatusKind kind) const;
  /// The one that hears of DATA_ON_READERS, and so instead of DATA_AVAILABLE (2.2.4.2.6).
  SubscriberListener* for_data_on_readers() const;
  bool has(StatusKind kind) const;

  /// The changed statuses of a reader and of its subscriber, with the participant's lock.
  struct Changes {
    StatusChanges& of_reader;
    StatusChanges& of_subscriber;
    std::mutex& mutex;
  };
  /// Without the lock: calls the listeners for what changed, which becomes read by that.
  void tell(AnyDataReader& reader, const Changes& changes) const;
  /// Without the lock: calls on_data_available, if there is a listener for it.
  void tell_of_data_available(AnyDataReader& reader, const Changes& changes) const;

 private:
  void tell_of_data(AnyDataReader& reader, const Changes& changes) const;

  Listening<DataReaderListener> own_;
  const Listening<SubscriberListener>& of_subscriber_;
  const Listening<DomainParticipantListener>& of_participant_;
};

}  // namespace ddssec::rtps
