// Subscriber of DDS 1.4, 2.2.2.5.2.
#pragma once

#include "rtps/dcps/data_reader.hpp"

namespace ddssec::rtps {

/// Made and deleted by its participant.
class Subscriber final : public Entity {
 public:
  ~Subscriber() override;

  DomainParticipant& participant() const { return participant_; }
  GroupQos qos() const;
  /// Errors: rtps_immutable_policy, rtps_qos_inconsistent.
  Status set_qos(const GroupQos& qos);
  Status enable() override;
  void set_listener(SubscriberListener* listener, StatusMask mask = kAnyStatus);

  Qos default_datareader_qos() const;
  /// Errors: rtps_qos_inconsistent.
  Status set_default_datareader_qos(const Qos& qos);

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
  /// Errors: rtps_precondition_not_met (another subscriber's, one with read conditions, or from
  /// within a callback).
  Status delete_datareader(AnyDataReader& reader);
  Status delete_contained_entities();
  /// Any of its readers on that topic; nullptr if there is none.
  AnyDataReader* lookup_datareader(std::string_view topic_name) const;
  /// Those that hold samples in these states.
  std::vector<AnyDataReader*> datareaders(const States& states = {}) const;
  /// Calls on_data_available of the readers that have data, as if nobody listened for
  /// DATA_ON_READERS.
  void notify_datareaders();

 private:
  friend class AnyDataReader;
  friend class DomainParticipant;
  Subscriber(DomainParticipant& participant, ParticipantContext& context, GroupQos qos);

  template <class R>
  Result<R*> create(Topic& topic, std::string_view type, std::optional<Qos> qos,
                    DataReaderListener* listener, StatusMask mask) {
    if (auto fits = check_topic(topic, type); !fits) return std::unexpected(fits.error());
    std::unique_ptr<R> reader(
        new R(*this, context_, topic, std::move(qos).value_or(default_datareader_qos())));
    auto* out = reader.get();
    reader->set_listener(listener, mask);
    if (auto adopted = adopt(std::move(reader)); !adopted) return std::unexpected(adopted.error());
    return out;
  }
  Status check_topic(const Topic& topic, std::string_view type) const;
  Status adopt(std::unique_ptr<AnyDataReader> reader);
  /// For DATA_ON_READERS alone.
  SubscriberListener* listener_for(StatusKind kind) const;
  bool has_listener(StatusKind) const override { return false; }  // its readers tell them
  void tell_listeners() override {}

  DomainParticipant& participant_;
  GroupQos qos_;
  Qos default_qos_ = default_reader_qos();
  Listening<SubscriberListener> listening_;
  std::vector<std::unique_ptr<AnyDataReader>> readers_;
};

}  // namespace ddssec::rtps
