// DataReader of DDS 1.4, 2.2.2.5.3, for serialized and for typed samples.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "rtps/dcps/content_filtered_topic.hpp"
#include "rtps/dcps/data_reader_listeners.hpp"
#include "rtps/dcps/endpoint.hpp"
#include "rtps/dcps/loans.hpp"
#include "rtps/dcps/requested_liveliness.hpp"
#include "rtps/dcps/sample_access.hpp"
#include "rtps/dcps/sample_reception.hpp"

namespace ddssec::rtps {

class Subscriber;

/// A reader of serialized samples; the base class of DataReader<T>. Created and deleted by its
/// subscriber. Thread-safe.
class AnyDataReader : public Endpoint {
 public:
  /// The largest number of loaned samples of one reader at the same time.
  static constexpr std::size_t kMaxLoans = 256;

  ~AnyDataReader() override;

  /// Returns the subscriber that owns it.
  Subscriber& subscriber() const;
  /// Returns nullptr if the reader receives all samples of its topic.
  ContentFilteredTopic* content_filtered_topic() const { return filter_.topic(); }
  /// Replaces the listener, which the caller owns; nullptr removes it. `mask` has the statuses that
  /// it handles; the others go to the listeners of its subscriber and participant. Waits until
  /// running callbacks of the former listener have returned (exceptions: rtps/dcps/listener.hpp).
  void set_listener(DataReaderListener* listener, StatusMask mask = kAnyStatus);

  /// Appends the samples that match the query to `out` and returns their number. Errors:
  /// rtps_not_enabled, rtps_bad_parameter (no such instance), rtps_precondition_not_met (coherent
  /// or ordered access of GROUP scope, and the call is not between begin_access and end_access).
  Result<std::size_t> access(const SampleQuery& query, std::vector<OctetSample>& out);
  /// Returns HANDLE_NIL if the instance is not known.
  InstanceHandle lookup_key(const KeyHash& key) const;
  /// Returns the serialized key of an instance. Errors: rtps_bad_parameter (no such instance).
  Result<Payload> octets_of_key(InstanceHandle instance) const;

  /// Creates a condition that is triggered while the reader holds samples in these states. The
  /// reader owns it.
  ReadCondition& create_readcondition(const States& states);
  /// Creates a condition that is triggered while the reader holds samples in these states that
  /// match the query; an empty expression matches all. The reader owns it. Errors:
  /// rtps_filter_invalid.
  Result<QueryCondition*> create_querycondition(const States& states, FilterText query);
  /// Deletes the condition. Errors: rtps_precondition_not_met (it belongs to another reader).
  Status delete_readcondition(ReadCondition& condition);
  /// Deletes its conditions. Pointers to them are invalid afterwards.
  void delete_contained_entities();

  /// Waits until the samples that the matched reliable writers held when they matched have arrived.
  /// Returns at once if DURABILITY is VOLATILE. Errors: rtps_timeout, rtps_not_enabled.
  Status wait_for_historical_data(std::chrono::nanoseconds timeout);
  /// Waits until the reader holds unread samples. Returns false if there are none after `timeout`,
  /// and at once within a listener if there are none. A waiting thread may serve the participant's
  /// sockets meanwhile.
  bool wait_for_unread(std::chrono::nanoseconds timeout) {
    return wait_for_samples(*this, {.sample = SampleState::not_read}, timeout);
  }
  /// As AnyDataReader::wait_for_unread, for samples in these states.
  friend bool wait_for_samples(AnyDataReader& reader, const States& states,
                               std::chrono::nanoseconds timeout);

  /// Each returns a status of DDS 1.4, 2.2.4.1, and resets its change counts.
  DeadlineMissedStatus requested_deadline_missed_status() { return read_deadline_status(); }
  IncompatibleQosStatus requested_incompatible_qos_status() { return read_incompatible_status(); }
  LivelinessChangedStatus liveliness_changed_status();
  SampleLostStatus sample_lost_status();
  SampleRejectedStatus sample_rejected_status();
  MatchedStatus subscription_matched_status() { return read_matched_status(); }
  std::vector<Guid> matched_publications() const { return matched_remotes(); }
  /// Returns what a matched writer announced. Errors: rtps_bad_parameter (the writer is not
  /// matched).
  Result<EndpointData> matched_publication_data(const Guid& writer) const {
    return matched_data(writer);
  }
  /// Returns the number of samples that could not be deserialized; never reset.
  std::uint64_t malformed() const { return reception_.samples().malformed(); }

 protected:
  friend class BuiltinTopics;
  friend class Group;
  friend class Subscriber;
  AnyDataReader(Group& subscriber, ParticipantContext& context, Topic& topic, Qos qos);
  /// Counts a sample that could not be deserialized as the type.
  void count_malformed() { reception_.samples().count_malformed(); }
  /// Removes the samples, which could not be deserialized as the type, and counts them. `taken`
  /// means that the reader does not hold them any more.
  void discard_malformed(std::span<const OctetSample> samples, bool taken);

  const std::shared_ptr<LoanCount> loans_ = std::make_shared<LoanCount>(kMaxLoans, "reader");

 private:
  friend class QueryCondition;
  void on_matched(const EndpointData& remote) override;
  void on_unmatched(const Guid& remote) override;
  bool on_change(Change& change) override { return reception_.on_change(change); }
  void on_sample_lost(std::int64_t count) override { reception_.on_lost(count); }
  void on_sample_dropped(const Guid& writer, std::uint32_t octets) override {
    reception_.on_dropped(writer, octets);
  }
  void on_signal(const Guid& writer, std::shared_ptr<LivelinessSignal> signal) override {
    liveliness_.on_signal(writer, std::move(signal));
  }
  void on_alive(const Guid& writer) override;
  void on_group(const Guid& writer, SequenceNumber group) override {
    reception_.on_group(writer, group);
  }

  /// Offers changes again that the reader refused for lack of room.
  void offer_again();

  void on_retired() override;
  Result<Guid> create(EndpointDescription request) override;
  void on_own_qos(const Qos& before) override { reception_.change_qos(before, qos_, enabled()); }
  Status check_unused() const override;
  bool has_listener(StatusKind kind) const override { return listeners_.has(kind); }
  void notify_listeners() override;

  DataReaderListeners listeners_;
  ReadConditions conditions_;
  ReaderFilter filter_;
  SampleReception reception_;
  RequestedLiveliness liveliness_;
};

/// A reader of serialized samples, with read(), take() and their variants (SampleAccess).
class OctetDataReader final : public AnyDataReader,
                              public SampleAccess<OctetDataReader, std::vector<OctetSample>> {
 private:
  friend class Subscriber;
  friend class SampleAccess<OctetDataReader, std::vector<OctetSample>>;
  using AnyDataReader::AnyDataReader;
  Result<std::size_t> fill(const SampleQuery& query, std::vector<OctetSample>& out) {
    out.clear();
    return access(query, out);
  }
};

/// A reader of T, with read(), take() and their variants (SampleAccess). Created and deleted by its
/// subscriber. Thread-safe.
/// - Into Samples<T>, samples are copied. If the same collection is passed again, its objects keep
///   their memory.
/// - Into LoanedSamples<T>, a FlatType is not copied. A call returns no more samples than kMaxLoans
///   leaves room for. Further error: rtps_precondition_not_met (kMaxLoans are out).
template <DdsType T>
class DataReader final : public AnyDataReader,
                         public SampleAccess<DataReader<T>, Samples<T>, LoanedSamples<T>> {
 public:
  /// Returns the oldest unread sample, and removes it or marks it as read. Empty if there is none,
  /// or if the reader is not enabled or may not be accessed now. Never waits.
  std::optional<Sample<T>> take_next_sample() { return next(true); }
  std::optional<Sample<T>> read_next_sample() { return next(false); }
  /// Returns the handle of the sample's instance; only the key of `sample` counts. HANDLE_NIL if
  /// the reader does not know the instance.
  InstanceHandle lookup_instance(const T& sample) const {
    Bytes scratch;
    return lookup_key(has_key<T>() ? key_hash(sample, scratch, keys_.hidden, version_of(qos()))
                                   : KeyHash{});
  }
  /// Returns a sample in which only the key is set. Errors: rtps_bad_parameter (no such instance).
  Result<T> key_value(InstanceHandle instance) const {
    const auto octets = octets_of_key(instance);
    if (!octets) return std::unexpected(octets.error());
    return deserialize_key<T>(octets->view());
  }

 private:
  friend class Subscriber;
  friend class SampleAccess<DataReader<T>, Samples<T>, LoanedSamples<T>>;
  using AnyDataReader::AnyDataReader;

  Result<std::size_t> fill(const SampleQuery& query, Samples<T>& out) {
    out.size_ = 0;
    return append(query, out);
  }
  Result<std::size_t> fill(SampleQuery query, LoanedSamples<T>& out) {
    out.clear();
    const auto counted = loans_->add(query.max_samples, topic_.name());
    if (!counted) return counted;
    out.loans_ = loans_;
    query.max_samples = *counted;
    const UnusedLoans unused(*loans_, *counted, out);
    return append(query, out);
  }

  // A sample that cannot be deserialized is removed, and the next one is returned in its place, so
  // that no writer hides samples of others. A writer could send such samples as fast as they are
  // removed, so their number is bounded.
  template <class C>
  Result<std::size_t> append(SampleQuery query, C& out) {
    const auto wanted = query.max_samples;
    std::size_t discarded = 0;
    while (discarded < HeldInstances::kMaxSamples) {
      query.max_samples = wanted - out.size();
      if (auto found = access(query, out.raw_); !found && discarded == 0) return found;
      const auto malformed = out.append_raw();
      if (malformed.empty()) break;
      discard_malformed(malformed, query.take);
      discarded += malformed.size();
      if (!has_more(query, out)) break;
    }
    if (discarded > 0) out.join_selections();
    return out.size();
  }
  /// True if the query can find more samples without finding the same ones again. Changes a query
  /// for the next instance to one for the instance that was found.
  template <class C>
  static bool has_more(SampleQuery& query, const C& found) {
    if (found.empty()) return true;
    if (query.scope == SampleQuery::Scope::next_instance) {
      query.scope = SampleQuery::Scope::instance;
      query.instance = info_of(found[0]).instance_handle;
    }
    return query.take || !query.states.sample.contains(SampleState::read);
  }
  static const SampleInfo& info_of(const Sample<T>& sample) { return sample.info; }
  static const SampleInfo& info_of(const LoanedSample<T>& sample) { return sample.info(); }
  std::optional<Sample<T>> next(bool take) {
    Samples<T> one;
    const SampleQuery query{
        .states = {.sample = SampleState::not_read}, .max_samples = 1, .take = take};
    if (!fill(query, one) || one.empty()) return std::nullopt;
    return std::move(one[0]);
  }
};

}  // namespace ddssec::rtps
