// DomainParticipantFactory of DDS 1.4, 2.2.2.2.2: not a singleton, as clock, random source and
// events are given to it.
#pragma once

#include "rtps/dcps/domain_participant.hpp"

namespace ddssec::rtps {

/// Its participants die with it. Thread-safe.
class DomainParticipantFactory {
 public:
  /// The environment's parts outlive the factory.
  explicit DomainParticipantFactory(const Environment& environment) : environment_(environment) {}

  /// Whether participants are enabled when they are made (ENTITY_FACTORY); true at first.
  void set_autoenable_created_entities(bool autoenable) { autoenable_ = autoenable; }

  /// Errors: those of DomainParticipant::create.
  Result<DomainParticipant*> create_participant(DomainParticipantOptions options,
                                                DomainParticipantListener* listener = nullptr,
                                                StatusMask mask = kAnyStatus);
  /// Errors: rtps_precondition_not_met (another factory's, or one that contains entities).
  Status delete_participant(DomainParticipant& participant);
  /// Any participant in that domain; nullptr if there is none.
  DomainParticipant* lookup_participant(DomainId domain) const;

 private:
  const Environment environment_;
  std::atomic<bool> autoenable_ = true;
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<DomainParticipant>> participants_;
};

}  // namespace ddssec::rtps
