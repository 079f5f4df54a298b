// Topic of DDS 1.4, 2.2.2.3.2.
#pragma once

#include <string>

#include "rtps/dcps/entity.hpp"
#include "rtps/dcps/type_support.hpp"

namespace ddssec::rtps {

class DomainParticipant;

/// A topic is created and deleted by its participant. Thread-safe.
class Topic final : public Entity {
 public:
  ~Topic() override;

  const std::string& name() const { return name_; }
  const std::string& type_name() const { return type_.name; }
  /// Returns what the endpoints on the topic need to know about the type.
  const TypeSupport& type() const { return type_; }
  /// Returns the participant that owns the topic, and outlives it.
  DomainParticipant& participant() const { return participant_; }

  /// Returns the policies that are in force.
  Qos qos() const;
  /// Changes the policies. Writers and readers on the topic keep theirs, and announce its
  /// TOPIC_DATA. Errors: rtps_qos_inconsistent, rtps_immutable_policy (once it is enabled).
  Status set_qos(const Qos& qos);
  Status enable() override;
  /// Replaces the listener, which the caller owns; nullptr removes it. `mask` has the statuses that
  /// it handles; the others go to the listener of its participant. Waits until running callbacks of
  /// the former listener have returned (exceptions: rtps/dcps/listener.hpp).
  void set_listener(TopicListener* listener, StatusMask mask = kAnyStatus);
  /// Returns the status and resets its change count.
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
  void notify_listeners() override;
  void on_inconsistent();

  DomainParticipant& participant_;
  const std::string name_;
  const TypeSupport type_;
  Qos qos_;
  ListenerAndMask<TopicListener> listening_;
  InconsistentTopicStatus inconsistent_;
  int users_ = 0;       ///< number of writers and readers on the topic
  int references_ = 1;  ///< how often it was created or found
};

}  // namespace ddssec::rtps
