// The readers that a writer matched, and what they have in common.
#pragma once

#include <map>

#include "rtps/reliability/locator_counts.hpp"
#include "rtps/reliability/message_sender.hpp"
#include "rtps/reliability/reader_proxy.hpp"

namespace ddssec::rtps {

/// What all have in common is counted, not computed anew whenever one comes or goes.
class MatchedReaders {
 public:
  using Proxies = std::map<Guid, ReaderProxy>;

  MatchedReaders(const EntityId& writer, bool writer_is_reliable)
      : writer_(writer), reliable_(writer_is_reliable) {}

  /// The reader is not known. It has acknowledged what lies below its range.
  ReaderProxy& add(MatchedReader reader, const ReaderProxy::Range& range);
  void remove(ReaderProxy& proxy);
  /// nullptr: not known.
  ReaderProxy* find(const Guid& reader) {
    const auto at = proxies_.find(reader);
    return at == proxies_.end() ? nullptr : &at->second;
  }
  bool contains(const Guid& reader) const { return proxies_.contains(reader); }
  std::size_t size() const { return proxies_.size(); }
  Proxies& all() { return proxies_; }
  const Proxies& all() const { return proxies_; }

  /// How many do not get everything.
  std::size_t filtered() const { return filtered_; }
  void set_filter(ReaderProxy& proxy, std::shared_ptr<ChangeFilter> filter);
  /// A form of keys that all can read.
  KeyReading key_reading() const { return {bare_only_ > 0, short_is_hash_ > 0}; }

  void acknowledge(ReaderProxy& proxy, SequenceNumber through);
  const AcknowledgedNumbers& acknowledged() const { return acknowledged_; }

  /// DSCP of what is sent to them.
  void set_dscp(std::uint8_t dscp) { dscp_ = dscp; }
  /// Some get messages.
  bool any_remote() const { return !locators_.all().empty(); }
  Receiver one(const ReaderProxy& proxy) const {
    const auto& [prefix, entity] = proxy.reader().guid;
    return {{prefix, proxy.reader().locators, dscp_}, entity};
  }
  /// All of them at once.
  Receiver everybody() const {
    return is_pairwise() ? one(proxies_.begin()->second)
                         : Receiver{{{}, locators_.all(), dscp_}, kEntityIdUnknown};
  }

 private:
  /// Its reader is the only one, and what it gets is protected by the key of that pair.
  bool is_pairwise() const { return writer_ == kVolatileMessageWriter && size() == 1; }
  void count(const ReaderProxy& proxy, int by);

  const EntityId writer_;
  const bool reliable_;
  std::uint8_t dscp_ = 0;
  Proxies proxies_;
  AcknowledgedNumbers acknowledged_;  ///< of those that acknowledge
  LocatorCounts locators_;
  std::size_t bare_only_ = 0, short_is_hash_ = 0;  ///< with that KeyReading
  std::size_t filtered_ = 0;
};

}  // namespace ddssec::rtps
