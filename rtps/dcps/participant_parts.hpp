// What a participant consists of, out of sight of the applications that include its header.
#pragma once

#include "rtps/dcps/discovered_entities.hpp"
#include "rtps/dcps/domain_participant.hpp"
#include "rtps/dcps/groups.hpp"
#include "rtps/dcps/liveliness.hpp"
#include "rtps/dcps/topic_descriptions.hpp"
#include "rtps/durability/durable_stores.hpp"

namespace ddssec::rtps {

/// The parts of one participant. They use the context of the participant, which therefore
/// makes them after it.
struct ParticipantParts {
  ParticipantParts(DomainParticipant& participant, EventSink& events);

  DurableStores stores;
  ManualLiveliness manual_liveliness;
  DiscoveredEntities discovered;
  TopicDescriptions topics;
  Groups groups;  // its members refer to topics
};

}  // namespace ddssec::rtps
