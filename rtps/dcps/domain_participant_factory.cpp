#include "rtps/dcps/domain_participant_factory.hpp"

#include <algorithm>

namespace ddssec::rtps {

Result<DomainParticipant*> DomainParticipantFactory::create_participant(
    DomainParticipantOptions options, DomainParticipantListener* listener, StatusMask mask) {
  const bool enabled = options.enabled && autoenable_;
  options.enabled = false;  // so that the listener receives everything from the beginning
  DDSSEC_ASSIGN_OR_RETURN(auto participant,
                          DomainParticipant::create(std::move(options), services_));
  participant->set_listener(listener, mask);
  if (enabled) DDSSEC_RETURN_IF_ERROR(participant->enable());
  const std::lock_guard lock(mutex_);
  participants_.push_back(std::move(participant));
  return participants_.back().get();
}

Status DomainParticipantFactory::delete_participant(DomainParticipant& participant) {
  DDSSEC_RETURN_IF_ERROR(check_not_in_callback(participant.context_));
  std::unique_ptr<DomainParticipant> dying;
  const std::lock_guard lock(mutex_);
  const auto at =
      std::ranges::find(participants_, &participant, &std::unique_ptr<DomainParticipant>::get);
  if (at == participants_.end())
    return precondition_not_met_error("participant", "one of this factory", "another's");
  if (participant.contains_entities())
    return precondition_not_met_error("participant", "one that contains no entities", "some");
  dying = std::move(*at);
  participants_.erase(at);
  return {};
}

DomainParticipant* DomainParticipantFactory::lookup_participant(DomainId domain) const {
  const std::lock_guard lock(mutex_);
  const auto at =
      std::ranges::find(participants_, domain, [](const auto& p) { return p->domain_id(); });
  return at == participants_.end() ? nullptr : at->get();
}

}  // namespace ddssec::rtps
