// Publisher of DDS 1.4, 2.2.2.4.1.
#pragma once

#include "rtps/dcps/data_writer.hpp"
#include "rtps/dcps/group.hpp"

namespace ddssec::rtps {

/// Made and deleted by its participant.
class Publisher final : public Group {
 public:
  ~Publisher() override { members_.clear(); }  // they know parts of this

  void set_listener(PublisherListener* listener, StatusMask mask = kAnyStatus);

  Qos default_datawriter_qos() const { return default_endpoint_qos(); }
  /// Errors: rtps_qos_inconsistent.
  Status set_default_datawriter_qos(const Qos& qos) { return set_default_endpoint_qos(qos); }

  /// A writer of T on a topic of that type. Errors: rtps_bad_parameter (another type),
  /// rtps_precondition_not_met (another participant's topic), rtps_qos_inconsistent.
  template <DdsType T>
  Result<DataWriter<T>*> create_datawriter(Topic& topic, std::optional<Qos> qos = {},
                                           DataWriterListener* listener = nullptr,
                                           StatusMask mask = kAnyStatus) {
    return create<DataWriter<T>>(topic, TypeTraits<T>::type_name, std::move(qos), listener, mask);
  }
  /// A writer of octets.
  Result<AnyDataWriter*> create_datawriter(Topic& topic, std::optional<Qos> qos = {},
                                           DataWriterListener* listener = nullptr,
                                           StatusMask mask = kAnyStatus) {
    return create<AnyDataWriter>(topic, topic.type_name(), std::move(qos), listener, mask);
  }
  /// Errors: rtps_precondition_not_met (another publisher's, or from within a callback).
  Status delete_datawriter(AnyDataWriter& writer) { return delete_member(writer); }
  /// Any of its writers on that topic; nullptr if there is none.
  AnyDataWriter* lookup_datawriter(std::string_view topic_name) const;
  /// With PRESENTATION.coherent_access: what its writers write from here to end_coherent_changes
  /// readers that ask for it see all at once or not at all. May be nested; the outermost pair
  /// counts. Errors: rtps_not_enabled.
  Status begin_coherent_changes();
  /// Errors: rtps_not_enabled, rtps_precondition_not_met (none was begun).
  Status end_coherent_changes();
  /// What its writers write is not sent before resume_publications. Errors: rtps_not_enabled.
  Status suspend_publications();
  /// Errors: rtps_not_enabled, rtps_precondition_not_met (not suspended).
  Status resume_publications();
  /// Of all its writers. Errors: rtps_timeout.
  Status wait_for_acknowledgments(std::chrono::nanoseconds most);

 private:
  friend class AnyDataWriter;
  friend class Groups;
  Publisher(DomainParticipant& participant, ParticipantContext& context, GroupQos qos);

  static AnyDataWriter& writer_of(const std::unique_ptr<Endpoint>& member) {
    return static_cast<AnyDataWriter&>(*member);  // a publisher creates nothing else
  }

  // With the lock held:
  /// With GROUP access: its name.
  std::optional<Guid> group_guid();
  /// A writer is new.
  void admit(StatefulWriter& writer, MonotonicTime now);
  void count_writers();
  /// For a writer's next change, which has that number.
  Coherence stamp(SequenceNumber& set_begin, SequenceNumber number);

  Listening<PublisherListener> listening_;
  bool presents_ = false;  ///< changes are stamped
  bool by_group_ = false;
  std::optional<Guid> guid_;
  WriterGroup group_;
  SequenceNumber set_begin_;  ///< group sequence number of the open set; 0 none
  int depth_ = 0;             ///< of begin_coherent_changes
  bool suspended_ = false;
};

}  // namespace ddssec::rtps
