// The readers that a writer matched, and the properties that they have in common.
#pragma once

#include <map>

#include "rtps/reliability/locator_counts.hpp"
#include "rtps/reliability/message_sender.hpp"
#include "rtps/reliability/reader_proxy.hpp"

namespace ddssec::rtps {

/// Common properties are counted, so that nothing is recomputed when a reader is added or removed.
/// The common destinations leave out the readers of participants that AmplificationLimit limits. A
/// message to all readers is sent to each of these readers separately, and charged to its limit.
class MatchedReaders {
 public:
  using Proxies = std::map<Guid, ReaderProxy>;
  static constexpr MonotonicTime kCheckPeriod = std::chrono::milliseconds(20);

  /// If `limit` is nullptr, no participant is limited.
  MatchedReaders(const EntityId& writer, bool writer_is_reliable,
                 AmplificationLimit* limit = nullptr)
      : writer_(writer), is_reliable_(writer_is_reliable), limit_(limit) {}

  /// Adds a reader that is not known. Changes below its range count as acknowledged.
  ReaderProxy& add(MatchedReader reader, const ReaderProxy::Range& range);
  void remove(ReaderProxy& proxy);
  /// Returns nullptr if the reader is not known.
  ReaderProxy* find(const Guid& reader) {
    const auto at = proxies_.find(reader);
    return at == proxies_.end() ? nullptr : &at->second;
  }
  const ReaderProxy* find(const Guid& reader) const {
    const auto at = proxies_.find(reader);
    return at == proxies_.end() ? nullptr : &at->second;
  }
  bool contains(const Guid& reader) const { return proxies_.contains(reader); }
  std::size_t size() const { return proxies_.size(); }
  Proxies& all() { return proxies_; }
  const Proxies& all() const { return proxies_; }

  /// Returns the number of readers that do not get everything.
  std::size_t filtered() const { return filtered_; }
  void set_filter(ReaderProxy& proxy, std::shared_ptr<ChangeFilter> filter);
  /// Returns the form of keys that all readers can read.
  KeyReading key_reading() const { return {bare_only_ > 0, short_is_hash_ > 0}; }

  void readdress(ReaderProxy& proxy, LocatorList locators);
  /// Sets whether the reader finds payloads in the writer's memory.
  void set_in_memory(ReaderProxy& proxy, bool in_memory);
  void acknowledge(ReaderProxy& proxy, SequenceNumber through);
  const AcknowledgedNumbers& acknowledged() const { return acknowledged_; }
  /// Finds out which readers acknowledge in time (Timeliness). Costs time for each reader, so it
  /// does nothing if it was called less than kCheckPeriod ago.
  void update_timeliness(SequenceNumber written, MonotonicTime now);
  /// Returns the acknowledged numbers of the readers that acknowledge in time.
  const AcknowledgedNumbers& acknowledged_in_time() const { return in_time_; }

  /// Sets the DSCP of messages to the readers.
  void set_dscp(std::uint8_t dscp) { dscp_ = dscp; }
  /// True if messages are sent to some readers.
  bool any_remote() const { return !locators_.all().empty() || limited_ > 0; }
  /// True if messages are sent to readers that find payloads in memory.
  bool any_in_memory() const { return !in_memory_.all().empty(); }
  /// Looks again whether AmplificationLimit limits the reader's participant.
  void update_limit(ReaderProxy& proxy);
  Receiver one(const ReaderProxy& proxy) const {
    return one(proxy.reader().guid, proxy.reader().locators);
  }
  Receiver one(const Guid& reader, const LocatorList& at) const {
    return {{reader.prefix, at, dscp_}, reader.entity};
  }
  /// Returns the receiver that stands for all readers that are not limited.
  Receiver all_readers() const {
    return is_pairwise() ? one(proxies_.begin()->second)
                         : Receiver{{{}, locators_.all(), dscp_}, kEntityIdUnknown};
  }
  Receiver readers_in_memory() const { return {{{}, in_memory_.all(), dscp_}, kEntityIdUnknown}; }
  Receiver readers_by_network() const { return {{{}, by_network_.all(), dscp_}, kEntityIdUnknown}; }
  /// Finds the limited readers whose participants are not limited any more.
  void release_proven();
  /// Calls `send` with each limited reader to which something may be sent.
  template <class Send>
  void for_each_limited(Send send) {
    if (limited_ == 0) return;
    for (auto& [guid, proxy] : proxies_)
      if (proxy.is_limited && limit_->left(guid.prefix, proxy.reader().locators) > 0) send(proxy);
  }
  /// Calls `send` with each receiver of what is for all readers.
  template <class Send>
  void for_all(Send send) {
    release_proven();
    for_each_limited([&](const ReaderProxy& proxy) { send(one(proxy)); });
    if (!locators_.all().empty()) send(all_readers());
  }
  /// The same for limited readers, and for those that do not find payloads in memory.
  template <class Send>
  void for_all_by_network(Send send) {
    release_proven();
    for_each_limited([&](const ReaderProxy& proxy) { send(one(proxy)); });
    if (!by_network_.all().empty()) send(readers_by_network());
  }

 private:
  /// True if there is only one reader, and the key of that pair protects what is sent to it.
  bool is_pairwise() const { return writer_ == kVolatileMessageWriter && size() == 1; }
  void count(const ReaderProxy& proxy, int by);
  /// Adds the reader's locators to the common destinations, or removes them.
  void add_locators(const ReaderProxy& proxy);
  void remove_locators(const ReaderProxy& proxy);
  LocatorCounts& locators_of(const ReaderProxy& proxy) {
    return proxy.in_memory ? in_memory_ : by_network_;
  }

  const EntityId writer_;
  const bool is_reliable_;
  AmplificationLimit* const limit_;
  std::uint8_t dscp_ = 0;
  Proxies proxies_;
  AcknowledgedNumbers acknowledged_;  ///< numbers of the readers that acknowledge
  AcknowledgedNumbers in_time_;
  MonotonicTime next_check_{};
  LocatorCounts locators_;                ///< of readers that are not limited
  LocatorCounts in_memory_, by_network_;  ///< the same locators, by how readers get payloads
  std::size_t limited_ = 0;               ///< number of limited readers
  std::size_t bare_only_ = 0, short_is_hash_ = 0;  ///< number of readers with that KeyReading
  std::size_t filtered_ = 0;
};

}  // namespace ddssec::rtps
