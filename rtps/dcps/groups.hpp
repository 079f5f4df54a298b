// The publishers and subscribers of a participant (DDS 1.4, 2.2.2.2.1).
#pragma once

#include "rtps/dcps/contained_entities.hpp"
#include "rtps/dcps/publisher.hpp"
#include "rtps/dcps/subscriber.hpp"

namespace ddssec::rtps {

/// The publishers and subscribers of one participant. Thread-safe. The calls are those of
/// DomainParticipant.
class Groups {
 public:
  /// Both must outlive this object.
  Groups(DomainParticipant& participant, ParticipantContext& context)
      : participant_(participant), context_(context), publishers_(context), subscribers_(context) {}

  /// Creates a group, which this object owns, and enables it if the participant is enabled and its
  /// policies say so.
  Publisher& create_publisher(GroupQos qos, PublisherListener* listener, StatusMask mask);
  Subscriber& create_subscriber(GroupQos qos, SubscriberListener* listener, StatusMask mask);
  /// Deletes the group. Errors: rtps_precondition_not_met (it is not empty or belongs to another
  /// participant, or the call is made from within a callback).
  Status remove(Publisher& publisher);
  Status remove(Subscriber& subscriber);

  /// Enables all groups. The caller holds the callback lock. Errors: those of Group::enable.
  Status enable();
  /// Announces the endpoints on `topic` again, after its TOPIC_DATA changed (2.2.3.2). Errors:
  /// those of Endpoint::regroup.
  Status announce_again(const Topic& topic);
  /// Removes all writers and reports their end to peers; waits as Group::conclude does.
  void conclude_writers();
  /// True if there is no group. The caller holds the lock.
  bool empty() const { return publishers_.all().empty() && subscribers_.all().empty(); }
  /// All groups, released from the participant.
  struct ReleasedGroups {
    ContainedEntities<Publisher>::All publishers;
    ContainedEntities<Subscriber>::All subscribers;
  };
  ReleasedGroups release() { return {publishers_.release(), subscribers_.release()}; }

 private:
  void enable_if_due(Group& group) const;

  DomainParticipant& participant_;
  ParticipantContext& context_;
  ContainedEntities<Publisher> publishers_;
  ContainedEntities<Subscriber> subscribers_;
};

}  // namespace ddssec::rtps
