// Publisher of DDS 1.4, 2.2.2.4.1.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "rtps/dcps/data_writer.hpp"
#include "rtps/dcps/group.hpp"
#include "rtps/reliability/writer_group.hpp"

namespace ddssec::rtps {

/// A publisher creates and deletes writers, which share its policies. Created and deleted by its
/// participant. Thread-safe.
class Publisher final : public Group {
 public:
  ~Publisher() override { members_.clear(); }  // they refer to members of this class

  /// Replaces the listener, which the caller owns; nullptr removes it. `mask` has the statuses that
  /// it handles; writers' own listeners are called first. Waits until running callbacks of the
  /// former listener have returned (exceptions: rtps/dcps/listener.hpp).
  void set_listener(PublisherListener* listener, StatusMask mask = kAnyStatus);

  Qos default_datawriter_qos() const { return default_endpoint_qos(); }
  /// Sets the policies of writers that are created without any. Errors: rtps_qos_inconsistent.
  Status set_default_datawriter_qos(const Qos& qos) { return set_default_endpoint_qos(qos); }

  /// Creates a writer of T, which the publisher owns, on a topic of that type. `qos`:
  /// default_datawriter_qos() if none is given. `listener`: see AnyDataWriter::set_listener.
  /// Errors: rtps_bad_parameter (the topic has another type), rtps_precondition_not_met (the topic
  /// belongs to another participant), rtps_qos_inconsistent. If the writer is enabled at once: for
  /// a secured participant also those of access control (the error names document and rule), and
  /// with DURABILITY TRANSIENT or PERSISTENT rtps_store_failed and rtps_store_unusable.
  template <DdsType T>
  Result<DataWriter<T>*> create_datawriter(Topic& topic, std::optional<Qos> qos = {},
                                           DataWriterListener* listener = nullptr,
                                           StatusMask mask = kAnyStatus) {
    return create<DataWriter<T>>(topic, TypeTraits<T>::type_name, std::move(qos), listener, mask);
  }
  /// Creates a writer of serialized samples. Errors: those of the call above.
  Result<AnyDataWriter*> create_datawriter(Topic& topic, std::optional<Qos> qos = {},
                                           DataWriterListener* listener = nullptr,
                                           StatusMask mask = kAnyStatus) {
    return create<AnyDataWriter>(topic, topic.type_name(), std::move(qos), listener, mask);
  }
  /// Deletes the writer. With autodispose_unregistered_instances its instances are disposed first,
  /// and the call waits for acknowledgments for at most 100 ms. Errors: rtps_precondition_not_met
  /// (the writer belongs to another publisher, or the call is made from within a callback).
  Status delete_datawriter(AnyDataWriter& writer) { return delete_member(writer); }
  /// Returns any of its writers on that topic, or nullptr if there is none.
  AnyDataWriter* lookup_datawriter(std::string_view topic_name) const;
  /// Begins a coherent set, if PRESENTATION.coherent_access is set. Readers that request coherent
  /// access see what the publisher's writers write until end_coherent_changes either completely or
  /// not at all. Calls may be nested; only the outermost pair has an effect. Errors:
  /// rtps_not_enabled.
  Status begin_coherent_changes();
  /// Ends the coherent set. Errors: rtps_not_enabled, rtps_precondition_not_met (no
  /// begin_coherent_changes before).
  Status end_coherent_changes();
  /// Holds back what its writers write, until resume_publications. Errors: rtps_not_enabled.
  Status suspend_publications();
  /// Sends what was held back. Errors: rtps_not_enabled, rtps_precondition_not_met (publications
  /// are not suspended).
  Status resume_publications();
  /// Waits until the samples of all its writers are acknowledged. Errors: rtps_timeout,
  /// rtps_not_enabled (one of the writers), rtps_store_failed.
  Status wait_for_acknowledgments(std::chrono::nanoseconds timeout);

 private:
  friend class AnyDataWriter;
  friend class Groups;
  Publisher(DomainParticipant& participant, ParticipantContext& context, GroupQos qos);

  static AnyDataWriter& writer_of(const std::unique_ptr<Endpoint>& member) {
    return static_cast<AnyDataWriter&>(*member);  // a publisher creates nothing else
  }

  // The caller holds the lock:
  /// Returns the GUID of this publisher in its writers' announcements. Empty without coherent or
  /// ordered access of GROUP scope.
  std::optional<Guid> group_guid();
  /// Prepares a new writer.
  void admit(StatefulWriter& writer);
  void count_writers();
  /// Returns the coherence fields of a writer's next change, which has this sequence number.
  CoherentSetInfo stamp(SequenceNumber& set_begin, SequenceNumber number);

  ListenerAndMask<PublisherListener> listening_;
  bool presents_ = false;  ///< true if changes are stamped
  bool is_by_group_ = false;
  std::optional<Guid> guid_;
  WriterGroup group_;
  SequenceNumber set_begin_;  ///< group sequence number of the open set; 0 if there is none
  int depth_ = 0;             ///< nesting depth of begin_coherent_changes
  bool is_suspended_ = false;
};

}  // namespace ddssec::rtps
