// The Publishers and Subscribers of a participant (DDS 1.4, 2.2.2.2.1).
#pragma once

#include "rtps/dcps/contained_entities.hpp"
#include "rtps/dcps/publisher.hpp"
#include "rtps/dcps/subscriber.hpp"

namespace ddssec::rtps {

/// Thread-safe. The calls are those of DomainParticipant.
class Groups {
 public:
  /// Both outlive it.
  Groups(DomainParticipant& participant, ParticipantContext& context)
      : participant_(participant), context_(context), publishers_(context), subscribers_(context) {}

  /// Errors: those of Group::enable.
  Result<Publisher*> create_publisher(GroupQos qos, PublisherListener* listener, StatusMask mask);
  Result<Subscriber*> create_subscriber(GroupQos qos, SubscriberListener* listener,
                                        StatusMask mask);
  /// Errors: rtps_precondition_not_met (it is not empty, another participant's, or from within a
  /// callback).
  Status remove(Publisher& publisher);
  Status remove(Subscriber& subscriber);

  /// With the lock of callbacks held. Errors: those of Group::enable.
  Status enable();
  /// The policies of a topic changed that others learn of with its endpoints (2.2.3.2). Errors:
  /// those of Endpoint::regroup.
  Status announce_again(const Topic& topic);
  /// All writers end, and say so; waits as Group::conclude.
  void conclude_writers();
  /// With the lock held.
  bool empty() const { return publishers_.all().empty() && subscribers_.all().empty(); }
  /// All leave.
  struct Released {
    ContainedEntities<Publisher>::All publishers;
    ContainedEntities<Subscriber>::All subscribers;
  };
  Released release() { return {publishers_.release(), subscribers_.release()}; }

 private:
  bool enables_new() const;

  DomainParticipant& participant_;
  ParticipantContext& context_;
  ContainedEntities<Publisher> publishers_;
  ContainedEntities<Subscriber> subscribers_;
};

}  // namespace ddssec::rtps
