// Publisher of DDS 1.4, 2.2.2.4.1.
#pragma once

#include "rtps/dcps/data_writer.hpp"

namespace ddssec::rtps {

/// Made and deleted by its participant.
class Publisher final : public Entity {
 public:
  ~Publisher() override;

  DomainParticipant& participant() const { return participant_; }
  GroupQos qos() const;
  /// Errors: rtps_immutable_policy, rtps_qos_inconsistent.
  Status set_qos(const GroupQos& qos);
  Status enable() override;
  void set_listener(PublisherListener* listener, StatusMask mask = kAnyStatus);

  Qos default_datawriter_qos() const;
  /// Errors: rtps_qos_inconsistent.
  Status set_default_datawriter_qos(const Qos& qos);

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
  Status delete_datawriter(AnyDataWriter& writer);
  Status delete_contained_entities();
  /// Any of its writers on that topic; nullptr if there is none.
  AnyDataWriter* lookup_datawriter(std::string_view topic_name) const;
  /// Of all its writers. Errors: rtps_timeout.
  Status wait_for_acknowledgments(std::chrono::nanoseconds most);

 private:
  friend class AnyDataWriter;
  friend class DomainParticipant;
  Publisher(DomainParticipant& participant, ParticipantContext& context, GroupQos qos);

  template <class W>
  Result<W*> create(Topic& topic, std::string_view type, std::optional<Qos> qos,
                    DataWriterListener* listener, StatusMask mask) {
    if (auto fits = check_topic(topic, type); !fits) return std::unexpected(fits.error());
    std::unique_ptr<W> writer(
        new W(*this, context_, topic, std::move(qos).value_or(default_datawriter_qos())));
    auto* out = writer.get();
    writer->set_listener(listener, mask);
    if (auto adopted = adopt(std::move(writer)); !adopted) return std::unexpected(adopted.error());
    return out;
  }
  Status check_topic(const Topic& topic, std::string_view type) const;
  Status adopt(std::unique_ptr<AnyDataWriter> writer);
  bool has_listener(StatusKind) const override { return false; }
  void tell_listeners() override {}

  DomainParticipant& participant_;
  GroupQos qos_;
  Qos default_qos_ = default_writer_qos();
  Listening<PublisherListener> listening_;
  std::vector<std::unique_ptr<AnyDataWriter>> writers_;
};

}  // namespace ddssec::rtps
