// Subscriber of DDS 1.4, 2.2.2.5.2.
#pragma once

#include "rtps/dcps/data_reader.hpp"
#include "rtps/dcps/group.hpp"

namespace ddssec::rtps {

/// Made and deleted by its participant.
class Subscriber final : public Group {
 public:
  ~Subscriber() override { members_.clear(); }  // they know parts of this

  void set_listener(SubscriberListener* listener, StatusMask mask = kAnyStatus);

  Qos default_datareader_qos() const { return default_endpoint_qos(); }
  /// Errors: rtps_qos_inconsistent.
  Status set_default_datareader_qos(const Qos& qos) { return set_default_endpoint_qos(qos); }

  /// A reader of T on a topic of that type. Errors: rtps_bad_parameter (another type),
  /// rtps_precondition_not_met (another participant's topic), rtps_qos_inconsistent.
  template <DdsType T>
  Result<DataReader<T>*> create_datareader(Topic& topic, std::optional<Qos> qos = {},
                                           DataReaderListener* listener = nullptr,
                                           StatusMask mask = kAnyStatus) {
    return create<DataReader<T>>(topic, TypeTraits<T>::type_name, std::move(qos), listener, mask);
  }
  /// A reader of octets.
  Result<OctetDataReader*> create_datareader(Topic& topic, std::optional<Qos> qos = {},
                                             DataReaderListener* listener = nullptr,
                                             StatusMask mask = kAnyStatus) {
    return create<OctetDataReader>(topic, topic.type_name(), std::move(qos), listener, mask);
  }
  /// Readers of what passes the filter.
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
  /// Errors: rtps_precondition_not_met (another subscriber's, one with read conditions, or from
  /// within a callback).
  Status delete_datareader(AnyDataReader& reader) { return delete_member(reader); }
  /// Any of its readers on that topic; nullptr if there is none.
  AnyDataReader* lookup_datareader(std::string_view topic_name) const;
  /// Until end_access nothing new is seen of coherent sets, whatever the scope, and of the ordered
  /// samples of a group: all readers show what was there when it began. May be nested. Errors:
  /// rtps_not_enabled.
  Status begin_access();
  /// Errors: rtps_not_enabled, rtps_precondition_not_met (none was begun).
  Status end_access();
  /// Those that hold samples in these states; with ordered access of GROUP scope one for each
  /// sample, in the order in which they should be read or taken one by one.
  std::vector<AnyDataReader*> datareaders(const States& states = {}) const;
  /// Calls on_data_available of the readers that have data, as if nothing listened for
  /// DATA_ON_READERS.
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

  // With the lock held:
  /// For its readers, if its PRESENTATION has GROUP scope and needs one.
  Presenter* presenter(const Presentation& presentation);
  bool is_accessing() const { return accesses_ > 0; }
  Status check_access() const;
  void pause(bool paused);

  Listening<SubscriberListener> listening_;
  std::unique_ptr<Presenter> presenter_;
  std::uint64_t arrivals_ = 0;
  int accesses_ = 0;
};

}  // namespace ddssec::rtps
