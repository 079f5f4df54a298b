// Topic of DDS 1.4, 2.2.2.3.2.
#pragma once

#include "rtps/dcps/entity.hpp"
#include "rtps/dcps/type_support.hpp"

namespace ddssec::rtps {

class DomainParticipant;

/// Created and deleted by its participant. Thread-safe.
class Topic final : public Entity {
 public:
  ~Topic() override;

  const std::string& name() const { return name_; }
  const std::string& type_name() const { return type_.name; }
  const TypeSupport& type() const { return type_; }
  DomainParticipant& participant() const { return participant_; }

  Qos qos() const;
  /// Errors: rtps_qos_inconsistent, rtps_immutable_policy.
  Status set_qos(const Qos& qos);
  Status enable() override;
  void set_listener(TopicListener* listener, StatusMask mask = kAnyStatus);
  /// Reading the status resets its change count.
  InconsistentTopicStatus inconsistent_topic_status();

 private:
  friend class BuiltinTopics;
  friend class ContentFilteredTopic;
  friend class TopicDescriptions;
  friend class Endpoint;
  Topic(DomainParticipant& participant, ParticipantContext& context, std::string name,
        TypeSupport type, Qos qos);

  TopicListener* listener_for(StatusKind kind) const;
  bool has_listener(StatusKind kind) const override { return listener_for(kind) != nullptr; }
  void tell_listeners() override;
  void on_inconsistent();

  DomainParticipant& participant_;
  const std::string name_;
  const TypeSupport type_;
  Qos qos_;
  Listening<TopicListener> listening_;
  InconsistentTopicStatus inconsistent_;
  int users_ = 0;       ///< number of writers and readers on the topic
  int references_ = 1;  ///< how often it was created or found
};

}  // namespace ddssec::rtps
