// The entities that a participant has discovered, and those that it ignores (DDS 1.4, 2.2.2.2.1.14
// to 2.2.2.2.1.17 and 2.2.2.2.1.27 to 2.2.2.2.1.30).
#pragma once

#include "rtps/dcps/builtin_topics.hpp"

namespace ddssec::rtps {

/// The remote entities of one participant. Thread-safe. The calls are those of DomainParticipant.
class DiscoveredEntities {
 public:
  /// `check`, which is called with the lock held, returns an error if the participant may not
  /// ignore anything yet. `context` must outlive this object.
  DiscoveredEntities(ParticipantContext& context, std::function<Status()> check)
      : context_(context), check_(std::move(check)) {}

  std::vector<Guid> participants() const;
  /// Returns what a participant announced. Errors: rtps_bad_parameter (no such participant).
  Result<ParticipantBuiltinTopicData> participant_data(const Guid& participant) const;
  /// Returns the topics on which at least one remote endpoint is known. Each pair of name and type
  /// is listed once.
  std::vector<TopicBuiltinTopicData> topics() const;

  // Ignores the entity permanently. Errors: those of `check`.
  Status ignore_participant(const Guid& participant);
  Status ignore_topic(const std::string& name);
  /// Ignores a remote writer or a remote reader.
  Status ignore_endpoint(const Guid& endpoint);

 private:
  Status change(const std::function<void(RtpsParticipant&)>& f);

  ParticipantContext& context_;
  std::function<Status()> check_;
};

}  // namespace ddssec::rtps
