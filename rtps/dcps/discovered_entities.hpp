// What a participant has discovered, and what of it is to be ignored (DDS 1.4, 2.2.2.2.1.14 to
// 2.2.2.2.1.17 and 2.2.2.2.1.27 to 2.2.2.2.1.30).
#pragma once

#include "rtps/dcps/builtin_topics.hpp"

namespace ddssec::rtps {

/// Thread-safe. The calls are those of DomainParticipant.
class DiscoveredEntities {
 public:
  /// `check` says with the lock held whether the participant may ignore anything yet. `context`
  /// outlives this.
  DiscoveredEntities(ParticipantContext& context, std::function<Status()> check)
      : context_(context), check_(std::move(check)) {}

  std::vector<Guid> participants() const;
  /// Errors: rtps_bad_parameter (none of them).
  Result<ParticipantBuiltinTopicData> participant_data(const Guid& participant) const;
  /// Topics of which a remote endpoint is known, by name and type.
  std::vector<TopicBuiltinTopicData> topics() const;

  // For good. Errors: those of `check`.
  Status ignore_participant(const Guid& participant);
  Status ignore_topic(const std::string& name);
  /// A writer or a reader.
  Status ignore_endpoint(const Guid& endpoint);

 private:
  Status change(const std::function<void(Participant&)>& f);

  ParticipantContext& context_;
  std::function<Status()> check_;
};

}  // namespace ddssec::rtps
