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
#include "rtps/dcps/loans.hpp"
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
  /// The largest number of loans of one writer at the same time.
  static constexpr std::size_t kMaxLoans = 64;

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
  /// Lends memory for one sample of `size` octets, with its encapsulation. All octets are 0.
  /// Errors: rtps_bad_parameter (not even the encapsulation fits), rtps_sample_too_large,
  /// rtps_precondition_not_met (kMaxLoans).
  Result<OctetLoan> loan_octets(std::size_t size);
  /// As loan_octets, but saves the time to set the octets to 0: they are undefined, and may be
  /// those of another sample of this process. Overwrite all of them.
  Result<OctetLoan> loan_octets_for_overwrite(std::size_t size);
  /// Writes the sample without a copy; `change.payload` does not count. After an error, the loan is
  /// still valid. Errors: those of the call above, rtps_precondition_not_met (the loan was written,
  /// or another writer lent it).
  Status write_octets(OctetLoan&& loan, OctetWrite change = {});
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

  const std::shared_ptr<LoanCount> loans_ = std::make_shared<LoanCount>(kMaxLoans, "writer");

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
  /// Lends a sample to be filled in place and then written. The members have their initial values.
  /// Errors: those of AnyDataWriter::loan_octets.
  Result<WriterLoan<T>> loan() requires FlatType<T> {
    auto loan = loan_for_overwrite();
    if (loan) new (loan->sample_) T{};
    return loan;
  }
  /// As loan, but saves the time to initialize the sample: its members are undefined, and may be
  /// octets of another sample of this process. Overwrite all of them.
  Result<WriterLoan<T>> loan_for_overwrite() requires FlatType<T> {
    static_assert(alignof(T) <= Payload::kAlignment);
    auto octets = loan_octets_for_overwrite(detail::kFlatPayload<T>);
    if (!octets) return std::unexpected(octets.error());
    detail::frame_flat<T>(octets->octets());
    void* const at = octets->octets().data() + kEncapsulationSize;
    return WriterLoan<T>(*std::move(octets), std::launder(static_cast<T*>(at)));
  }
  /// As the calls above, with a sample that this writer lent. Nothing is serialized or copied,
  /// unless the writer's encoding is XCDR2. After an error, the loan is still valid. Further error:
  /// rtps_precondition_not_met (the loan was written, or another writer lent it).
  template <std::same_as<WriterLoan<T>> Loan>
  Status write(Loan&& loan, InstanceHandle handle = {}) {
    return write_loan(loan, handle, std::nullopt);
  }
  template <std::same_as<WriterLoan<T>> Loan>
  Status write_w_timestamp(Loan&& loan, InstanceHandle handle, Time source_timestamp) {
    return write_loan(loan, handle, source_timestamp);
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
  Status write_loan(WriterLoan<T>& loan, InstanceHandle handle, std::optional<Time> time) {
    DDSSEC_RETURN_IF_ERROR(loan.octets_.check(loans_, topic_.name()));
    auto written = version() == XcdrVersion::xcdr1
                       ? write_octets(std::move(loan.octets_), change_of(*loan, handle, time))
                       : write_octets(with_payload(*loan, handle, time));
    if (written) loan = {};
    return written;
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
