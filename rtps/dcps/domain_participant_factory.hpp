// DomainParticipantFactory of DDS 1.4, 2.2.2.2.2. It is no singleton, because it receives its
// clock, random source and event sink from the caller.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "base/plugin_services.hpp"
#include "rtps/dcps/domain_participant.hpp"

namespace ddssec::rtps {

/// Creates participants and owns them; they are deleted with it. Thread-safe.
class DomainParticipantFactory {
 public:
  /// The clock, random source and event sink in `services` must outlive the factory.
  explicit DomainParticipantFactory(const PluginServices& services) : services_(services) {}

  /// Sets whether new participants are enabled when they are created (ENTITY_FACTORY). The default
  /// is true.
  void set_autoenable_created_entities(bool autoenable) { autoenable_ = autoenable; }

  /// Creates a participant, which the factory owns. The listener receives everything from the
  /// beginning. Errors: those of DomainParticipant::create.
  Result<DomainParticipant*> create_participant(DomainParticipantOptions options,
                                                DomainParticipantListener* listener = nullptr,
                                                StatusMask mask = kAnyStatus);
  /// Deletes the participant. Errors: rtps_precondition_not_met (it belongs to another factory or
  /// contains entities, or the call is made from within one of its callbacks).
  Status delete_participant(DomainParticipant& participant);
  /// Returns any participant in that domain, or nullptr if there is none.
  DomainParticipant* lookup_participant(DomainId domain) const;

 private:
  const PluginServices services_;
  std::atomic<bool> autoenable_ = true;
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<DomainParticipant>> participants_;
};

}  // namespace ddssec::rtps
