// DataWriter of DDS 1.4, 2.2.2.4.2.
#pragma once

#include "rtps/dcps/data_writer_listeners.hpp"
#include "rtps/dcps/endpoint.hpp"
#include "rtps/dcps/offered_liveliness.hpp"
#include "rtps/dcps/source_timestamps.hpp"
#include "rtps/dcps/writer_durability.hpp"
#include "rtps/dcps/writer_instances.hpp"
#include "rtps/dcps/writer_lifespan.hpp"

namespace ddssec::rtps {

class Publisher;

/// A change of an instance, serialized already.
struct OctetWrite {
  BytesView payload = {};                           ///< with its encapsulation
  std::optional<KeyHash> key = {};                  ///< for types with keys
  std::function<Bytes()> serialized_key = nullptr;  ///< called for a new instance only
  InstanceHandle handle = {};                       ///< HANDLE_NIL: whichever the key names
  std::optional<Time> source_timestamp = {};        ///< nothing: now
};

/// A writer of octets; what DataWriter<T> stands on. Made and deleted by its publisher. Any thread
/// may call.
class AnyDataWriter : public Endpoint, private Timed {
 public:
  ~AnyDataWriter() override;

  Publisher& publisher() const;
  void set_listener(DataWriterListener* listener, StatusMask mask = kAnyStatus);

  // All: errors rtps_not_enabled, rtps_bad_parameter (a key is missing, the handle names another
  // instance, a source time before the last one with BY_SOURCE_TIMESTAMP), rtps_out_of_resources
  // (max_instances), rtps_history_full (after RELIABILITY.max_blocking_time).
  Status write_octets(const OctetWrite& change);
  Status dispose_octets(const OctetWrite& change);
  /// Errors besides: rtps_precondition_not_met (the instance is not registered).
  Status unregister_octets(const OctetWrite& change);
  Result<InstanceHandle> register_octets(const OctetWrite& change);
  /// HANDLE_NIL if the instance is not registered.
  InstanceHandle lookup_key(const KeyHash& key) const;
  /// The serialized key. Errors: rtps_bad_parameter (no such instance).
  Result<Bytes> octets_of_key(InstanceHandle instance) const;

  /// With DURABILITY PERSISTENT also that all is stored. Errors: rtps_timeout, rtps_not_enabled,
  /// rtps_store_failed.
  Status wait_for_acknowledgments(std::chrono::nanoseconds most);
  /// Errors: rtps_not_enabled.
  Status assert_liveliness();

  DeadlineMissedStatus offered_deadline_missed_status() { return read_deadline_status(); }
  IncompatibleQosStatus offered_incompatible_qos_status() { return read_incompatible_status(); }
  LivelinessLostStatus liveliness_lost_status();
  MatchedStatus publication_matched_status() { return read_matched_status(); }
  std::vector<Guid> matched_subscriptions() const { return matched_remotes(); }
  /// What a matched reader announced. Errors: rtps_bad_parameter (it is not matched).
  Result<EndpointData> matched_subscription_data(const Guid& reader) const {
    return matched_data(reader);
  }

 protected:
  friend class Group;
  friend class Publisher;
  AnyDataWriter(Group& publisher, ParticipantContext& context, Topic& topic, Qos qos);
  XcdrVersion version() const { return version_; }

 private:
  void on_acknowledged() override { context_.notify(); }
  std::shared_ptr<ChangeFilter> filter_for(const EndpointData& reader) override;
  void on_time(MonotonicTime now) override;

  Result<Guid> create(EndpointRequest request) override;
  /// What a writer before it left in the store becomes its history.
  Status restore(EndpointRequest& request);
  void on_own_qos(const Qos& before) override;
  void conclude() override;
  void linger(std::chrono::steady_clock::time_point deadline) override;
  Status submit(const OctetWrite& change, StatusInfo status);
  Result<InstanceHandle> instance_of(const OctetWrite& change);
  Status wait_for_room(std::unique_lock<std::mutex>& lock, const OctetWrite& change);
  void after_write(const KeyHash& key, StatusInfo status, SequenceNumber number, MonotonicTime now);
  void end_set(Coherence marker, MonotonicTime now);
  StatefulWriter& protocol() const { return *context_.protocol().local_endpoints().writer(guid_); }
  bool has_listener(StatusKind kind) const override {
    return listeners_.for_status(kind) != nullptr;
  }
  void tell_listeners() override { listeners_.tell(*this, changes_, context_.mutex()); }

  const XcdrVersion version_;
  DataWriterListeners listeners_;
  std::optional<WriterInstances> instances_;
  SourceTimestamps source_timestamps_;
  WriterDurability durability_;
  OfferedLiveliness liveliness_;
  WriterLifespan lifespan_;
  SequenceNumber set_begin_;  ///< of the open coherent set; 0: wrote nothing in it
  bool concluded_ = false;    ///< there was something to say
  LivelinessLostStatus liveliness_lost_;
};

/// One thread at a time: what a sample is serialized into belongs to the writer.
template <DdsType T>
class DataWriter final : public AnyDataWriter {
 public:
  /// Errors: see AnyDataWriter.
  Status write(const T& sample, InstanceHandle handle = {}) {
    return write_octets(with_payload(sample, handle, std::nullopt));
  }
  Status write_w_timestamp(const T& sample, InstanceHandle handle, Time source_timestamp) {
    return write_octets(with_payload(sample, handle, source_timestamp));
  }
  /// The instance is over.
  Status dispose(const T& sample, InstanceHandle handle = {}) {
    return dispose_octets(with_key(sample, handle, std::nullopt));
  }
  Status dispose_w_timestamp(const T& sample, InstanceHandle handle, Time source_timestamp) {
    return dispose_octets(with_key(sample, handle, source_timestamp));
  }
  /// This writer has no more to say about the instance; with
  /// autodispose_unregistered_instances (the default) it is over as well.
  Status unregister_instance(const T& sample, InstanceHandle handle = {}) {
    return unregister_octets(with_key(sample, handle, std::nullopt));
  }
  Status unregister_instance_w_timestamp(const T& sample, InstanceHandle handle,
                                         Time source_timestamp) {
    return unregister_octets(with_key(sample, handle, source_timestamp));
  }
  Result<InstanceHandle> register_instance(const T& sample) {
    return register_octets(with_key(sample, {}, std::nullopt));
  }
  InstanceHandle lookup_instance(const T& sample) {
    return lookup_key(key_of(sample).value_or(KeyHash{}));
  }
  /// A sample with its key alone. Errors: rtps_bad_parameter.
  Result<T> key_value(InstanceHandle instance) const {
    const auto octets = octets_of_key(instance);
    if (!octets) return std::unexpected(octets.error());
    return deserialize_key<T>(*octets);
  }

 private:
  friend class Publisher;
  using AnyDataWriter::AnyDataWriter;

  std::optional<KeyHash> key_of(const T& sample) {
    static const bool keyed = has_key<T>();
    if (!keyed) return std::nullopt;
    return key_hash(sample, scratch_, keys_.hidden, version());
  }
  OctetWrite change_of(const T& sample, InstanceHandle handle, std::optional<Time> time) {
    return {payload_, key_of(sample),
            [&sample, this] {
              Bytes out;
              serialize_key(sample, out, version());
              return out;
            },
            handle, time};
  }
  OctetWrite with_payload(const T& sample, InstanceHandle handle, std::optional<Time> time) {
    serialize(sample, payload_, version());
    return change_of(sample, handle, time);
  }
  OctetWrite with_key(const T& sample, InstanceHandle handle, std::optional<Time> time) {
    serialize_key(sample, payload_, version());
    return change_of(sample, handle, time);
  }

  Bytes payload_, scratch_;
};

}  // namespace ddssec::rtps
