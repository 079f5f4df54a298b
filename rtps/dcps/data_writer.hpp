// DataWriter of DDS 1.4, 2.2.2.4.2.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "rtps/dcps/data_writer_listeners.hpp"
#include "rtps/dcps/endpoint.hpp"
#include "rtps/dcps/offered_liveliness.hpp"
#include "rtps/dcps/source_timestamps.hpp"
#include "rtps/dcps/writer_durability.hpp"
#include "rtps/dcps/writer_instances.hpp"
#include "rtps/dcps/writer_lifespan.hpp"
#include "rtps/reliability/payload_buffer.hpp"

namespace ddssec::rtps {

class Publisher;
class StatefulWriter;

/// A change of an instance, already serialized.
struct OctetWrite {
  BytesView payload = {};                           ///< with its encapsulation
  std::optional<KeyHash> key = {};                  ///< required for types with keys
  std::function<Bytes()> serialized_key = nullptr;  ///< called only for a new instance
  /// HANDLE_NIL means the instance that the key names.
  InstanceHandle handle = {};
  std::optional<Time> source_timestamp = {};  ///< if it is empty, the source time is now
  /// If it has octets, it is written instead of `payload`, without a copy. It may not change any
  /// more.
  Payload shared = {};

  /// Returns what is written.
  BytesView octets() const { return shared.size() > 0 ? shared.view() : payload; }
};

/// A writer of serialized samples; the base class of DataWriter<T>. Created and deleted by its
/// publisher. Thread-safe.
class AnyDataWriter : public Endpoint, private TimedObject {
 public:
  ~AnyDataWriter() override;

  /// Returns the publisher that owns it.
  Publisher& publisher() const;
  /// Replaces the listener, which the caller owns; nullptr removes it. `mask` has the statuses that
  /// it handles; the others go to the listeners of its publisher and participant. Waits until
  /// running callbacks of the former listener have returned (exceptions: rtps/dcps/listener.hpp).
  void set_listener(DataWriterListener* listener, StatusMask mask = kAnyStatus);

  /// Writes a sample. The octets of `change.payload` are copied. Waits for room for at most
  /// RELIABILITY.max_blocking_time; within a listener it does not wait.
  /// Errors:
  /// - rtps_not_enabled
  /// - rtps_bad_parameter: the key is missing, the handle names another instance, or with
  ///   BY_SOURCE_TIMESTAMP the source time is before the previous one
  /// - rtps_out_of_resources: max_instances
  /// - rtps_sample_too_large: readers would drop it
  /// - rtps_history_full: no room in time
  /// - with DURABILITY TRANSIENT or PERSISTENT also rtps_store_failed, rtps_store_unusable,
  ///   rtps_timeout (too much waits to be stored) and out_of_memory
  Status write_octets(const OctetWrite& change);
  /// Disposes the instance. `change.payload` is the serialized key. Errors: those of write_octets.
  Status dispose_octets(const OctetWrite& change);
  /// Unregisters the instance, because the writer will not write it any more. Errors: those of
  /// write_octets, rtps_precondition_not_met (the instance is not registered).
  Status unregister_octets(const OctetWrite& change);
  /// Makes the instance known to the writer, as writing does. Sends nothing. Errors:
  /// rtps_not_enabled, rtps_bad_parameter, rtps_out_of_resources.
  Result<InstanceHandle> register_octets(const OctetWrite& change);
  /// Returns HANDLE_NIL if the instance is not registered.
  InstanceHandle lookup_key(const KeyHash& key) const;
  /// Returns the serialized key of an instance. Errors: rtps_bad_parameter (no such instance).
  Result<Bytes> octets_of_key(InstanceHandle instance) const;

  /// Waits until all matched reliable readers have acknowledged everything. With DURABILITY
  /// PERSISTENT also waits until everything is stored. Errors: rtps_timeout, rtps_not_enabled; from
  /// the store rtps_store_failed, rtps_store_unusable and out_of_memory.
  Status wait_for_acknowledgments(std::chrono::nanoseconds timeout);
  /// Asserts that the writer is alive (DDS 1.4, 2.2.2.4.2.22), for LIVELINESS MANUAL_BY_PARTICIPANT
  /// or MANUAL_BY_TOPIC. A write does so too. Errors: rtps_not_enabled.
  Status assert_liveliness();

  /// Each returns a status of DDS 1.4, 2.2.4.1, and resets its change counts.
  DeadlineMissedStatus offered_deadline_missed_status() { return read_deadline_status(); }
  IncompatibleQosStatus offered_incompatible_qos_status() { return read_incompatible_status(); }
  LivelinessLostStatus liveliness_lost_status();
  MatchedStatus publication_matched_status() { return read_matched_status(); }
  std::vector<Guid> matched_subscriptions() const { return matched_remotes(); }
  /// Returns what a matched reader announced. Errors: rtps_bad_parameter (the reader is not
  /// matched).
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

  Result<Guid> create(EndpointDescription request) override;
  /// Loads the samples that an earlier writer left in the store into the history of the new writer.
  Status restore(EndpointDescription& request);
  void on_retired() override;
  void on_own_qos(const Qos& before) override;
  void conclude() override;
  void await_acknowledgment(std::chrono::steady_clock::time_point deadline) override;
  Status submit(const OctetWrite& change, StatusInfo status);
  Result<InstanceHandle> instance_of(const OctetWrite& change);
  Status wait_for_room(std::unique_lock<std::mutex>& lock, const OctetWrite& change);
  void after_write(const KeyHash& key, StatusInfo status, SequenceNumber number, MonotonicTime now);
  /// Returns the time at which on_time has something to do.
  MonotonicTime next_work(MonotonicTime now) const;
  void end_set(CoherentSetInfo marker, MonotonicTime now);
  StatefulWriter& protocol() const;
  bool has_listener(StatusKind kind) const override {
    return listeners_.for_status(kind) != nullptr;
  }
  void notify_listeners() override { listeners_.notify(*this, changes_, context_.mutex()); }

  const XcdrVersion version_;
  DataWriterListeners listeners_;
  std::optional<WriterInstances> instances_;
  SourceTimestamps source_timestamps_;
  WriterDurability durability_;
  OfferedLiveliness liveliness_;
  WriterLifespan lifespan_;
  /// The sequence number at which the open coherent set begins; 0 if nothing was written in it.
  SequenceNumber set_begin_;
  bool is_concluded_ = false;  ///< conclude() sent at least one dispose
  LivelinessLostStatus liveliness_lost_;
};

/// A writer of T. Thread-safe. A sample is serialized once, into the payload that the history
/// keeps.
template <DdsType T>
class DataWriter final : public AnyDataWriter {
 public:
  /// Writes a sample. `handle` is that of its instance, or HANDLE_NIL. The source time is now. May
  /// wait for RELIABILITY.max_blocking_time. Errors of all calls that write:
  /// AnyDataWriter::write_octets.
  Status write(const T& sample, InstanceHandle handle = {}) {
    return write_octets(with_payload(sample, handle, std::nullopt));
  }
  /// As write, with this source time, a time of the calendar. Further error:
  /// rtps_bad_parameter (DESTINATION_ORDER is BY_SOURCE_TIMESTAMP, and the time is before the last
  /// one).
  Status write_w_timestamp(const T& sample, InstanceHandle handle, Time source_timestamp) {
    return write_octets(with_payload(sample, handle, source_timestamp));
  }
  /// Disposes the instance; only the key of `sample` counts.
  Status dispose(const T& sample, InstanceHandle handle = {}) {
    return dispose_octets(with_key(sample, handle, std::nullopt));
  }
  /// As dispose, with a source time. Further error: that of write_w_timestamp.
  Status dispose_w_timestamp(const T& sample, InstanceHandle handle, Time source_timestamp) {
    return dispose_octets(with_key(sample, handle, source_timestamp));
  }
  /// Unregisters the instance, because the writer will not write it any more. With
  /// autodispose_unregistered_instances (the default) the instance is disposed as well. Further
  /// error: rtps_precondition_not_met (the instance is not registered).
  Status unregister_instance(const T& sample, InstanceHandle handle = {}) {
    return unregister_octets(with_key(sample, handle, std::nullopt));
  }
  /// As unregister_instance, with a source time. Further error: that of write_w_timestamp.
  Status unregister_instance_w_timestamp(const T& sample, InstanceHandle handle,
                                         Time source_timestamp) {
    return unregister_octets(with_key(sample, handle, source_timestamp));
  }
  /// See AnyDataWriter::register_octets.
  Result<InstanceHandle> register_instance(const T& sample) {
    return register_octets(change_of(sample, {}, std::nullopt));
  }
  /// Returns the handle of the sample's instance; only the key of `sample` counts. HANDLE_NIL if
  /// the instance is not registered.
  InstanceHandle lookup_instance(const T& sample) {
    return lookup_key(key_of(sample).value_or(KeyHash{}));
  }
  /// Returns a sample in which only the key is set. Errors: rtps_bad_parameter (no such instance).
  Result<T> key_value(InstanceHandle instance) const {
    const auto octets = octets_of_key(instance);
    if (!octets) return std::unexpected(octets.error());
    return deserialize_key<T>(*octets);
  }

 private:
  friend class Publisher;
  using AnyDataWriter::AnyDataWriter;

  /// The buffer into which one call serializes a key, until it has returned.
  class KeyBuffer {
   public:
    explicit KeyBuffer(DataWriter& writer)
        : writer_(writer),
          has_kept_(!writer.kept_in_use_.test_and_set(std::memory_order_acquire)) {}
    ~KeyBuffer() {
      if (has_kept_) writer_.kept_in_use_.clear(std::memory_order_release);
    }
    KeyBuffer(const KeyBuffer&) = delete;
    KeyBuffer& operator=(const KeyBuffer&) = delete;
    Bytes& octets() { return has_kept_ ? writer_.kept_ : own_; }

   private:
    DataWriter& writer_;
    const bool has_kept_;
    Bytes own_;
  };

  std::optional<KeyHash> key_of(const T& sample) {
    static const bool keyed = has_key<T>();
    if (!keyed) return std::nullopt;
    return key_hash(sample, KeyBuffer(*this).octets(), keys_.hidden, version());
  }
  /// Returns the change without its payload. It refers to the sample.
  OctetWrite change_of(const T& sample, InstanceHandle handle, std::optional<Time> time) {
    return {.key = key_of(sample),
            .serialized_key =
                [&sample, this] {
                  Bytes out;
                  serialize_key(sample, out, version());
                  return out;
                },
            .handle = handle,
            .source_timestamp = time};
  }
  OctetWrite with_payload(const T& sample, InstanceHandle handle, std::optional<Time> time) {
    auto out = change_of(sample, handle, time);
    PayloadBuffer buffer(sizes_.expected());
    serialize(sample, buffer, version());
    sizes_.note(buffer.size());
    out.shared = std::move(buffer).finish();
    return out;
  }
  OctetWrite with_key(const T& sample, InstanceHandle handle, std::optional<Time> time) {
    auto out = change_of(sample, handle, time);
    PayloadBuffer buffer(Payload::kMinOctets);
    serialize_key(sample, buffer, version());
    out.shared = std::move(buffer).finish();
    return out;
  }

  std::atomic_flag kept_in_use_;
  Bytes kept_;
  PayloadSizes sizes_;
};

}  // namespace ddssec::rtps
