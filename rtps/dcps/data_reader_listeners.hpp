// Selects the listener for each status of a DataReader (DDS 1.4, 2.2.4.3).
#pragma once

#include "rtps/dcps/listener.hpp"
#include "rtps/dcps/status_changes.hpp"

namespace ddssec::rtps {

/// Holds a DataReader's own listener. A status that it does not handle goes to the subscriber's
/// listener, then to the participant's.
class DataReaderListeners {
 public:
  /// Both must outlive this object.
  DataReaderListeners(const ListenerAndMask<SubscriberListener>& of_subscriber,
                      const ListenerAndMask<DomainParticipantListener>& of_participant)
      : of_subscriber_(of_subscriber), of_participant_(of_participant) {}

  // The caller holds the participant's lock:
  /// Returns true if there was one before.
  bool set(DataReaderListener* listener, StatusMask mask) { return own_.set(listener, mask); }
  /// Returns nullptr if there is none.
  DataReaderListener* for_status(StatusKind kind) const;
  /// Returns the listener for DATA_ON_READERS, which is called instead of those for DATA_AVAILABLE
  /// (2.2.4.2.6).
  SubscriberListener* for_data_on_readers() const;
  bool has(StatusKind kind) const;

  /// The changed statuses of a reader and of its subscriber, and the mutex of the participant's
  /// lock.
  struct Changes {
    StatusChanges& of_reader;
    StatusChanges& of_subscriber;
    std::mutex& mutex;
  };
  /// Calls the listeners for the statuses that changed, which marks them as read. The caller does
  /// not hold the lock.
  void notify(AnyDataReader& reader, const Changes& changes) const;
  /// Calls on_data_available, if there is a listener for it. The caller does not hold the lock.
  void notify_of_data_available(AnyDataReader& reader, const Changes& changes) const;

 private:
  void notify_of_data(AnyDataReader& reader, const Changes& changes) const;

  ListenerAndMask<DataReaderListener> own_;
  const ListenerAndMask<SubscriberListener>& of_subscriber_;
  const ListenerAndMask<DomainParticipantListener>& of_participant_;
};

}  // namespace ddssec::rtps
