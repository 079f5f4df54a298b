// Processes the changes that a DataReader receives (DDS 1.4, 2.2.2.5.1 and 2.2.4.1).
#pragma once

#include "rtps/dcps/participant_context.hpp"
#include "rtps/dcps/read_conditions.hpp"
#include "rtps/dcps/reader_filter.hpp"
#include "rtps/dcps/reader_presentation.hpp"
#include "rtps/dcps/received_samples.hpp"
#include "rtps/dcps/status_changes.hpp"
#include "rtps/dcps/topic.hpp"

namespace ddssec::rtps {

/// Passes changes from the protocol through PRESENTATION to the samples, and updates statuses and
/// conditions. Has its own timer. The caller holds the participant's lock.
class SampleReception final : private PresentedReader, private TimedObject {
 public:
  /// The objects that it reports to. All must outlive it.
  struct Reports {
    StatusChanges& of_reader;
    StatusChanges& of_subscriber;
    ReadConditions& conditions;
    std::function<void(InstanceHandle)> deadline_missed;
  };
  /// The objects that it needs to know about the reader. All must outlive it.
  struct Reader {
    ParticipantContext& context;
    const Topic& topic;
    const Qos& qos;
    const KeyProtection& keys;
    ReaderFilter& filter;
    const Guid& guid;  ///< valid once the reader is enabled
  };
  SampleReception(const Reader& reader, Reports reports);

  /// Starts when the reader is enabled. For `of_group` and `paused` see ReaderPresentation.
  /// `arrivals` counts the samples of all readers of the subscriber.
  struct Subscription {
    Presenter* of_group;
    std::uint64_t& arrivals;
    bool paused;
  };
  void start(const Qos& announced, const Subscription& subscription);
  /// Call it before destruction.
  void stop();
  /// Applies changed policies. Before the start, any of them may change.
  void change_qos(const Qos& before, const Qos& now, bool started);

  void add_writer(const EndpointData& writer);
  void remove_writer(const Guid& writer);
  /// Notes that these writers are no longer alive.
  void lose_writers(std::span<const Guid> writers, MonotonicTime now);
  /// Takes the change, or returns false if it has no room for it now.
  bool on_change(Change& change);
  void on_group(const Guid& writer, SequenceNumber group);
  void on_lost(std::int64_t count);
  void on_dropped(const Guid& writer, std::uint32_t octets);

  /// Appends the samples that match the query and marks the data statuses as read. Returns true if
  /// a change that was refused for lack of room may be offered again. Call `after_access`
  /// afterwards.
  bool select(const SampleQuery& query, std::vector<OctetSample>& out);
  void after_access(bool taken);
  /// Removes samples that cannot be deserialized as the type, unless they were taken. Returns as
  /// `select` does.
  bool discard_malformed(std::span<const OctetSample> samples, bool taken);
  /// Pauses the reader's own Presenter, or lets it go on. The subscriber pauses its own.
  void pause(bool paused, MonotonicTime now);
  /// Schedules the next call of the Presenter.
  void schedule_presenter() { call_at(presentation_.next_tick()); }
  /// Removes everything about those of the instances that have ended.
  void forget_ended(std::span<const KeyHash> keys);
  void update_conditions() { reports_.conditions.update(samples_.cache()); }
  /// Evaluates a query for all samples again, and updates the conditions.
  void match(QueryMatches& query);

  const ReaderCache& cache() const { return samples_.cache(); }
  ReceivedSamples& samples() { return samples_; }
  const ReceivedSamples& samples() const { return samples_; }
  SampleLostStatus& lost_status() { return lost_; }
  SampleRejectedStatus& rejected_status() { return rejected_; }

 private:
  KeyHash instance_of(const Change& change) const override;
  Room room_for(const WantedRoom& wanted, const Guid& writer) const override;
  bool present(Change& change) override { return store(change); }
  void note_left(const Guid& writer) override;
  void note_lost(std::size_t samples) override { on_lost(static_cast<std::int64_t>(samples)); }
  void give_up(const Guid& writer, std::size_t samples, Limit limit) override;
  void on_time(MonotonicTime now) override;
  /// Call it when samples have left the reader.
  void present_again();
  bool store(Change& change);
  void reject(const Change& change, const ReaderCache::StoreReport& stored, bool is_new);
  void report_crowded(const Guid& writer, SampleRejectedReason reason);
  void report_time_ahead(const Guid& writer);
  void report_unreadable_key(const Change& change);
  void report_malformed(const OctetSample& sample);
  void note_data();

  ParticipantContext& context_;
  const Topic& topic_;
  ReaderFilter& filter_;
  const KeyProtection& keys_;
  const Guid& reader_;
  const Reports reports_;
  ReceivedSamples samples_;
  ReaderPresentation presentation_{*this};
  std::uint64_t arrivals_ = 0;
  bool has_refused_ = false;   ///< true if a writer waits for room
  bool is_exclusive_ = false;  ///< OWNERSHIP is EXCLUSIVE
  std::pair<Guid, SequenceNumber> last_rejected_;
  SampleLostStatus lost_;
  SampleRejectedStatus rejected_;
  /// The numbers of changes rejected by the limits that identities share: on instances, and on
  /// samples.
  std::uint64_t crowded_ = 0, crowded_samples_ = 0;
  std::uint64_t given_up_ = 0;   ///< number of sets that were given up
  std::uint64_t discarded_ = 0;  ///< number of samples that could not be deserialized
};

}  // namespace ddssec::rtps
