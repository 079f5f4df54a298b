// DataWriter of DDS 1.4, 2.2.2.4.2.
#pragma once

#include "rtps/cdr/cdr_writer.hpp"
#include "rtps/cdr/key_hash.hpp"
#include "rtps/dcps/domain_participant.hpp"

namespace ddssec::rtps {

/// A writer of octets that are serialized already; what DataWriter<T> stands on.
class WriterCore final : private EndpointListener {
 public:
  static Result<std::unique_ptr<WriterCore>> create(DomainParticipant& participant,
                                                    Participant::EndpointRequest request);
  ~WriterCore() override;

  /// Errors: rtps_history_full (after RELIABILITY.max_blocking_time).
  Status write(BytesView payload, const std::optional<KeyHash>& key, StatusInfo status = {},
               bool key_only = false);
  MatchedStatus matched() const;
  IncompatibleQosStatus incompatible_qos() const;
  /// False: not everything was acknowledged in time.
  bool wait_for_acknowledgments(std::chrono::nanoseconds most);
  const Guid& guid() const { return guid_; }

 private:
  explicit WriterCore(DomainParticipant& participant) : participant_(participant) {}
  void on_matched(const EndpointData& remote) override;
  void on_unmatched(const Guid& remote) override;
  void on_inconsistent_topic(const EndpointData&) override {}
  void on_sample_lost(std::int64_t) override {}
  void on_alive(const Guid&) override {}
  void on_incompatible_qos(const Guid& remote, const QosMismatch& mismatch) override;
  bool on_change(Change&) override { return true; }
  void on_acknowledged() override;

  DomainParticipant& participant_;
  Guid guid_;
  std::chrono::nanoseconds max_blocking_time_{};
  MatchedStatus matched_;
  std::vector<Guid> remotes_;
  IncompatibleQosStatus incompatible_;
};

/// One thread at a time.
template <DdsType T>
class DataWriter {
 public:
  /// Errors: rtps_qos_inconsistent.
  static Result<DataWriter> create(DomainParticipant& participant, std::string topic,
                                   Qos qos = default_writer_qos()) {
    const auto version = qos.data_representation.empty() ||
                                 qos.data_representation.front() != DataRepresentation::xcdr2
                             ? XcdrVersion::xcdr1
                             : XcdrVersion::xcdr2;
    auto core = WriterCore::create(
        participant,
        {std::move(topic), std::string(TypeTraits<T>::type_name), std::move(qos), has_key<T>()});
    if (!core) return std::unexpected(core.error());
    return DataWriter(std::move(*core), version);
  }

  /// Errors: rtps_history_full.
  Status write(const T& sample) {
    serialize(sample, payload_, version_);
    return core_->write(payload_, key_of(sample));
  }
  /// The instance is gone; with `unregister` also this writer's claim to it.
  Status dispose(const T& sample, bool unregister = false) {
    serialize_key(sample, payload_, version_);
    return core_->write(payload_, key_of(sample), {true, unregister}, true);
  }
  Status unregister_instance(const T& sample) {
    serialize_key(sample, payload_, version_);
    return core_->write(payload_, key_of(sample), {false, true}, true);
  }
  MatchedStatus matched() const { return core_->matched(); }
  IncompatibleQosStatus incompatible_qos() const { return core_->incompatible_qos(); }
  bool wait_for_acknowledgments(std::chrono::nanoseconds most) {
    return core_->wait_for_acknowledgments(most);
  }
  const Guid& guid() const { return core_->guid(); }

 private:
  DataWriter(std::unique_ptr<WriterCore> core, XcdrVersion version)
      : core_(std::move(core)), version_(version) {}
  std::optional<KeyHash> key_of(const T& sample) {
    static const bool keyed = has_key<T>();
    if (!keyed) return std::nullopt;
    return key_hash(sample, scratch_);
  }

  std::unique_ptr<WriterCore> core_;
  XcdrVersion version_;
  Bytes payload_, scratch_;
};

}  // namespace ddssec::rtps
