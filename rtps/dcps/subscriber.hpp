// Subscriber of DDS 1.4, 2.2.2.5.2.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "rtps/dcps/data_reader.hpp"
#include "rtps/dcps/group.hpp"

namespace ddssec::rtps {

/// A subscriber creates and deletes readers, which share its policies. Created and deleted by its
/// participant. Thread-safe.
class Subscriber final : public Group {
 public:
  ~Subscriber() override { members_.clear(); }  // they refer to members of this class

  /// Replaces the listener, which the caller owns; nullptr removes it. `mask` has the statuses that
  /// it handles; readers' own listeners are called first. Waits until running callbacks of the
  /// former listener have returned (exceptions: rtps/dcps/listener.hpp).
  void set_listener(SubscriberListener* listener, StatusMask mask = kAnyStatus);

  Qos default_datareader_qos() const { return default_endpoint_qos(); }
  /// Sets the policies of readers that are created without any. Errors: rtps_qos_inconsistent.
  Status set_default_datareader_qos(const Qos& qos) { return set_default_endpoint_qos(qos); }

  /// Creates a reader of T, which the subscriber owns, on a topic of that type. `qos`:
  /// default_datareader_qos() if none is given. `listener`: see AnyDataReader::set_listener.
  /// Errors: rtps_bad_parameter (the topic has another type), rtps_precondition_not_met (the topic
  /// belongs to another participant), rtps_qos_inconsistent. If the reader is enabled at once, for
  /// a secured participant also those of access control (the error names document and rule).
  template <DdsType T>
  Result<DataReader<T>*> create_datareader(Topic& topic, std::optional<Qos> qos = {},
                                           DataReaderListener* listener = nullptr,
                                           StatusMask mask = kAnyStatus) {
    return create<DataReader<T>>(topic, TypeTraits<T>::type_name, std::move(qos), listener, mask);
  }
  /// Creates a reader of serialized samples. Errors: those of the call above.
  Result<OctetDataReader*> create_datareader(Topic& topic, std::optional<Qos> qos = {},
                                             DataReaderListener* listener = nullptr,
                                             StatusMask mask = kAnyStatus) {
    return create<OctetDataReader>(topic, topic.type_name(), std::move(qos), listener, mask);
  }
  /// Creates a reader that receives only the samples that pass the topic's filter. Errors: those of
  /// the call above, and rtps_filter_invalid.
  template <DdsType T>
  Result<DataReader<T>*> create_datareader(ContentFilteredTopic& topic, std::optional<Qos> qos = {},
                                           DataReaderListener* listener = nullptr,
                                           StatusMask mask = kAnyStatus) {
    return create_filtered<DataReader<T>>(topic, TypeTraits<T>::type_name, std::move(qos), listener,
                                          mask);
  }
  Result<OctetDataReader*> create_datareader(ContentFilteredTopic& topic,
                                             std::optional<Qos> qos = {},
                                             DataReaderListener* listener = nullptr,
                                             StatusMask mask = kAnyStatus) {
    return create_filtered<OctetDataReader>(topic, topic.related_topic().type_name(),
                                            std::move(qos), listener, mask);
  }
  /// Deletes the reader and its samples. Errors: rtps_precondition_not_met (the reader belongs to
  /// another subscriber or has read conditions, or the call is made from within a callback).
  Status delete_datareader(AnyDataReader& reader) { return delete_member(reader); }
  /// Returns any of its readers on that topic, or nullptr if there is none.
  AnyDataReader* lookup_datareader(std::string_view topic_name) const;
  /// Begins an access. Until end_access, the readers show no new coherent sets, whatever the scope,
  /// and no new samples of a group with ordered access. All readers show what they held when the
  /// access began. Calls may be nested. Errors: rtps_not_enabled.
  Status begin_access();
  /// Ends the access. Errors: rtps_not_enabled, rtps_precondition_not_met (no begin_access before).
  Status end_access();
  /// Returns the readers that hold samples in these states. With ordered access of GROUP scope the
  /// list has one entry for each sample, in the order in which the samples should be read or taken
  /// one by one.
  std::vector<AnyDataReader*> datareaders(const States& states = {}) const;
  /// Calls on_data_available for the readers that have unread data, as if there were no listener
  /// for DATA_ON_READERS. Calls none if a callback of this participant waits for the caller.
  void notify_datareaders();

 private:
  friend class AnyDataReader;
  friend class BuiltinTopics;
  friend class Groups;
  Subscriber(DomainParticipant& participant, ParticipantContext& context, GroupQos qos);

  template <class R>
  Result<R*> create_filtered(ContentFilteredTopic& topic, std::string_view type,
                             std::optional<Qos> qos, DataReaderListener* listener,
                             StatusMask mask) {
    return create<R>(topic.related_topic(), type, std::move(qos), [&](R& reader) -> Status {
      reader.set_listener(listener, mask);
      const auto held = lock();
      return static_cast<AnyDataReader&>(reader).filter_.attach(topic);
    });
  }

  // The caller holds the lock:
  /// Returns the Presenter that its readers share, or nullptr unless PRESENTATION has GROUP scope
  /// and needs one.
  Presenter* presenter(const Presentation& presentation);
  bool is_accessing() const { return accesses_ > 0; }
  Status check_access() const;
  void pause(bool paused);

  ListenerAndMask<SubscriberListener> listening_;
  std::unique_ptr<Presenter> presenter_;
  std::uint64_t arrivals_ = 0;
  int accesses_ = 0;
};

}  // namespace ddssec::rtps
