// DataReader of DDS 1.4, 2.2.2.5.3.
#pragma once

#include <deque>

#include "rtps/cdr/cdr_reader.hpp"
#include "rtps/cdr/key_hash.hpp"
#include "rtps/dcps/domain_participant.hpp"

namespace ddssec::rtps {

/// A reader of octets; what DataReader<T> stands on.
class ReaderCore final : private EndpointListener {
 public:
  /// Where RESOURCE_LIMITS says "unlimited".
  static constexpr std::size_t kMostSamples = 65536;
  static constexpr std::size_t kMostOctets = std::size_t{256} << 20;

  /// Which instance a change without key hash belongs to; nothing if its payload cannot be read.
  using KeyOf = std::function<std::optional<KeyHash>(const Change&)>;
  static Result<std::unique_ptr<ReaderCore>> create(DomainParticipant& participant,
                                                    Participant::EndpointRequest request,
                                                    KeyOf key_of);
  ~ReaderCore() override;

  /// The oldest that is held.
  std::optional<Change> take_next();
  /// False: nothing came in time.
  bool wait_for_data(std::chrono::nanoseconds most);
  /// Called after data came, from the participant's thread.
  void on_data(std::function<void()> callback);
  MatchedStatus matched() const;
  IncompatibleQosStatus incompatible_qos() const;
  /// Samples that could not be read (SAMPLE_REJECTED is never needed: a full reader lets writers
  /// wait).
  std::uint64_t malformed() const;
  void count_malformed() { ++malformed_; }
  const Guid& guid() const { return guid_; }

 private:
  ReaderCore(DomainParticipant& participant, const Qos& qos, KeyOf key_of);
  void on_matched(const EndpointData& remote) override;
  void on_unmatched(const Guid& remote) override;
  void on_inconsistent_topic(const EndpointData&) override {}
  void on_sample_lost(std::int64_t) override {}
  void on_alive(const Guid&) override {}
  void on_incompatible_qos(const Guid& remote, const QosMismatch& mismatch) override;
  bool on_change(Change& change) override;
  void on_acknowledged() override {}
  void make_room_in_instance(const KeyHash& key);

  DomainParticipant& participant_;
  Guid guid_;
  const History history_;
  const std::size_t most_samples_;
  KeyOf key_of_;
  std::deque<Change> samples_;
  std::size_t octets_ = 0;
  std::function<void()> on_data_;
  MatchedStatus matched_;
  std::vector<Guid> remotes_;
  IncompatibleQosStatus incompatible_;
  std::atomic<std::uint64_t> malformed_ = 0;
};

template <DdsType T>
struct Sample {
  T data{};
  SampleInfo info;
};

template <DdsType T>
class DataReader {
 public:
  /// Errors: rtps_qos_inconsistent.
  static Result<DataReader> create(DomainParticipant& participant, std::string topic,
                                   Qos qos = default_reader_qos()) {
    auto core = ReaderCore::create(
        participant,
        {std::move(topic), std::string(TypeTraits<T>::type_name), std::move(qos), has_key<T>()},
        has_key<T>() ? ReaderCore::KeyOf(key_of) : nullptr);
    if (!core) return std::unexpected(core.error());
    return DataReader(std::move(*core));
  }

  /// The oldest sample that is held, if any; unreadable ones are counted and passed over.
  std::optional<Sample<T>> take() {
    while (auto change = core_->take_next()) {
      const auto octets = change->payload.view();
      auto data = change->key_only ? deserialize_key<T>(octets) : deserialize<T>(octets);
      if (!data) {
        core_->count_malformed();
        continue;
      }
      const auto state = change->status.disposed       ? InstanceState::not_alive_disposed
                         : change->status.unregistered ? InstanceState::not_alive_no_writers
                                                       : InstanceState::alive;
      Sample<T> sample{std::move(*data), {}};
      sample.info.publication_handle = change->writer;
      sample.info.instance_state = state;
      sample.info.source_timestamp = change->source_time;
      sample.info.valid_data = !change->key_only;
      return sample;
    }
    return std::nullopt;
  }
  bool wait_for_data(std::chrono::nanoseconds most) { return core_->wait_for_data(most); }
  void on_data(std::function<void()> callback) { core_->on_data(std::move(callback)); }
  MatchedStatus matched() const { return core_->matched(); }
  IncompatibleQosStatus incompatible_qos() const { return core_->incompatible_qos(); }
  std::uint64_t malformed() const { return core_->malformed(); }
  const Guid& guid() const { return core_->guid(); }

 private:
  explicit DataReader(std::unique_ptr<ReaderCore> core) : core_(std::move(core)) {}
  static std::optional<KeyHash> key_of(const Change& change) {
    const auto octets = change.payload.view();
    const auto data = change.key_only ? deserialize_key<T>(octets) : deserialize<T>(octets);
    if (!data) return std::nullopt;
    Bytes scratch;
    return key_hash(*data, scratch);
  }

  std::unique_ptr<ReaderCore> core_;
};

}  // namespace ddssec::rtps
