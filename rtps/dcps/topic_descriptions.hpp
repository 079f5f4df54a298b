// The Topics and ContentFilteredTopics of a participant (DDS 1.4, 2.2.2.2.1 and 2.2.2.3.1).
#pragma once

#include "rtps/dcps/contained_entities.hpp"
#include "rtps/dcps/content_filtered_topic.hpp"

namespace ddssec::rtps {

/// The topics of one participant, which all have different names. Thread-safe. The calls are those
/// of DomainParticipant.
class TopicDescriptions {
 public:
  /// For `announce_types` see DomainParticipantOptions. The other arguments must outlive this
  /// object.
  TopicDescriptions(DomainParticipant& participant, ParticipantContext& context,
                    bool announce_types)
      : participant_(participant),
        context_(context),
        announce_types_(announce_types),
        topics_(context),
        filtered_(context) {}

  /// Creates a topic. Errors: rtps_precondition_not_met (the name is already in use),
  /// rtps_qos_inconsistent, rtps_bad_parameter (the name of the topic or type is empty or longer
  /// than 256 characters).
  Result<Topic*> create(std::string name, TypeSupport type, const Qos& qos, TopicListener* listener,
                        StatusMask mask);
  /// Creates a content-filtered topic. Errors: rtps_filter_invalid, rtps_precondition_not_met (the
  /// name is already in use, or the topic belongs to another participant), rtps_bad_parameter (the
  /// name is invalid).
  Result<ContentFilteredTopic*> create_filtered(std::string name, Topic& related,
                                                FilterText filter);
  /// Both return nullptr if there is none.
  Topic* lookup(std::string_view name) const;
  ContentFilteredTopic* lookup_filtered(std::string_view name) const;
  /// See DomainParticipant::find_topic. Errors: rtps_timeout, those of create.
  Result<Topic*> find(const std::string& name, std::chrono::nanoseconds timeout);
  /// Deletes the topic. Errors: rtps_precondition_not_met (it is in use or belongs to another
  /// participant, or the call is made from within a callback).
  Status remove(Topic& topic);
  Status remove(ContentFilteredTopic& topic);

  /// Enables all topics. The caller holds the callback lock. Errors: those of Topic::enable.
  Status enable();
  /// True if there is no topic. The caller holds the lock.
  bool empty() const { return topics_.all().empty() && filtered_.all().empty(); }
  /// All topics, released from the participant. Content-filtered topics refer to the others and are
  /// destroyed first.
  struct ReleasedTopics {
    ContainedEntities<Topic>::All topics;
    ContainedEntities<ContentFilteredTopic>::All filtered;
  };
  ReleasedTopics release() { return {topics_.release(), filtered_.release()}; }

 private:
  bool drop_reference(Topic& topic, bool& unused) const;
  static Status check_name(std::string_view name);
  Status check_new_name(std::string_view name) const;

  DomainParticipant& participant_;
  ParticipantContext& context_;
  const bool announce_types_;
  ContainedEntities<Topic> topics_;
  ContainedEntities<ContentFilteredTopic> filtered_;
};

}  // namespace ddssec::rtps
