// Listeners of DDS 1.4 (2.2.2.1.5 and 2.2.4.3).
// - They are called by the participant's thread, or by poll(), one at a time for each participant.
// - They may read, take, write, and create and enable entities, also those of other participants.
// - They must not wait: calls that would wait time out at once.
// - They cannot delete entities of their own participant (rtps_precondition_not_met). A call that
//   deletes an entity of another participant waits until the listeners of that one have returned.
//   If one of these waits for the caller, the call is refused with rtps_precondition_not_met.
// - They must not destroy their own participant: see ~DomainParticipant.
// - A listener must outlive its entity, or be removed before with set_listener(nullptr).
//   set_listener waits until running callbacks have returned, except those that wait for the
//   caller: its own, and those of another participant that replace or delete something here.
// - An exception that leaves a listener is counted and reported (rtps_exception), and the
//   participant goes on.
#pragma once

#include <utility>

#include "rtps/dcps/status.hpp"

namespace ddssec::rtps {

class AnyDataReader;
class AnyDataWriter;
class Subscriber;
class Topic;

/// A listener for a topic. When a listener is called with a status, the status counts as read: its
/// change counts begin again at 0.
class TopicListener {
 public:
  virtual ~TopicListener() = default;
  /// A remote endpoint uses the topic's name with another type.
  virtual void on_inconsistent_topic(Topic&, const InconsistentTopicStatus&) {}
};

/// A listener for a writer, or, at a publisher or participant, for all of its writers.
class DataWriterListener {
 public:
  virtual ~DataWriterListener() = default;
  /// An instance was not written within the DEADLINE period.
  virtual void on_offered_deadline_missed(AnyDataWriter&, const DeadlineMissedStatus&) {}
  /// A reader was found that requests what the writer does not offer. The status names the policy
  /// and both values.
  virtual void on_offered_incompatible_qos(AnyDataWriter&, const IncompatibleQosStatus&) {}
  /// The writer did not assert its liveliness within its lease.
  virtual void on_liveliness_lost(AnyDataWriter&, const LivelinessLostStatus&) {}
  /// A reader matched, or no longer does.
  virtual void on_publication_matched(AnyDataWriter&, const MatchedStatus&) {}
};

/// A listener for all writers of a publisher.
class PublisherListener : public virtual DataWriterListener {};

/// A listener for a reader, or, at a subscriber or participant, for all of its readers.
class DataReaderListener {
 public:
  virtual ~DataReaderListener() = default;
  /// An instance got no sample within the DEADLINE period.
  virtual void on_requested_deadline_missed(AnyDataReader&, const DeadlineMissedStatus&) {}
  /// A writer was found that does not offer what the reader requests. The status names the policy
  /// and both values.
  virtual void on_requested_incompatible_qos(AnyDataReader&, const IncompatibleQosStatus&) {}
  /// A sample had no room within RESOURCE_LIMITS.
  virtual void on_sample_rejected(AnyDataReader&, const SampleRejectedStatus&) {}
  /// A matched writer is alive again, or is no longer alive.
  virtual void on_liveliness_changed(AnyDataReader&, const LivelinessChangedStatus&) {}
  /// The reader holds samples that are new. Take or read until there are none, because one call may
  /// be about several samples.
  virtual void on_data_available(AnyDataReader&) {}
  /// A writer matched, or no longer does.
  virtual void on_subscription_matched(AnyDataReader&, const MatchedStatus&) {}
  /// Samples of a matched writer will never arrive.
  virtual void on_sample_lost(AnyDataReader&, const SampleLostStatus&) {}
};

/// A listener for a subscriber. While a listener for DATA_ON_READERS is installed here,
/// on_data_available of that subscriber's readers is not called.
class SubscriberListener : public virtual DataReaderListener {
 public:
  /// At least one of its readers holds samples that are new.
  virtual void on_data_on_readers(Subscriber&) {}
};

/// A listener for a participant: it is called for its topics, and for all of its writers and
/// readers.
class DomainParticipantListener : public virtual TopicListener,
                                  public virtual PublisherListener,
                                  public virtual SubscriberListener {};

/// A listener and the statuses that it handles. A status without a listener is passed to the
/// containing entity.
template <class L>
struct ListenerAndMask {
  L* listener = nullptr;
  StatusMask mask;
  /// Returns true if there was a listener before.
  bool set(L* next, StatusMask statuses) {
    mask = statuses;
    return std::exchange(listener, next) != nullptr;
  }
  L* for_status(StatusKind kind) const {
    return listener != nullptr && mask.contains(kind) ? listener : nullptr;
  }
};

}  // namespace ddssec::rtps
