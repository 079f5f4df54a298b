#include "rtps/reliability/matched_readers.hpp"

namespace ddssec::rtps {

ReaderProxy& MatchedReaders::add(MatchedReader reader, const ReaderProxy::Range& range) {
  const auto guid = reader.guid;
  auto& proxy = proxies_.try_emplace(guid, std::move(reader), range, is_reliable_).first->second;
  acknowledge(proxy, range.first.previous());
  proxy.is_limited = limit_ != nullptr && limit_->is_limited(guid.prefix);
  count(proxy, 1);
  return proxy;
}

void MatchedReaders::remove(ReaderProxy& proxy) {
  count(proxy, -1);
  acknowledged_.remove(proxy.place);
  in_time_.remove(proxy.place_in_time);
  proxies_.erase(proxies_.find(proxy.reader().guid));
}

void MatchedReaders::set_filter(ReaderProxy& proxy, std::shared_ptr<ChangeFilter> filter) {
  filtered_ -= proxy.is_filtered() ? 1 : 0;
  proxy.set_filter(std::move(filter));
  filtered_ += proxy.is_filtered() ? 1 : 0;
}

void MatchedReaders::readdress(ReaderProxy& proxy, LocatorList locators) {
  remove_locators(proxy);
  proxy.set_locators(std::move(locators));
  add_locators(proxy);
}

void MatchedReaders::set_in_memory(ReaderProxy& proxy, bool in_memory) {
  remove_locators(proxy);
  proxy.in_memory = in_memory;
  add_locators(proxy);
}

void MatchedReaders::update_limit(ReaderProxy& proxy) {
  const bool is_limited = limit_ != nullptr && limit_->is_limited(proxy.reader().guid.prefix);
  if (proxy.is_limited == is_limited) return;
  remove_locators(proxy);
  proxy.is_limited = is_limited;
  add_locators(proxy);
}

void MatchedReaders::release_proven() {
  if (limited_ == 0) return;
  for (auto& [guid, proxy] : proxies_) update_limit(proxy);
}

void MatchedReaders::add_locators(const ReaderProxy& proxy) {
  const auto& locators = proxy.reader().locators;
  if (proxy.is_limited) {
    ++limited_;
    return;
  }
  locators_.add(locators);
  locators_of(proxy).add(locators);
}

void MatchedReaders::remove_locators(const ReaderProxy& proxy) {
  const auto& locators = proxy.reader().locators;
  if (proxy.is_limited) {
    --limited_;
    return;
  }
  locators_.remove(locators);
  locators_of(proxy).remove(locators);
}

void MatchedReaders::acknowledge(ReaderProxy& proxy, SequenceNumber through) {
  proxy.set_acknowledged(through);
  if (!proxy.acknowledges()) return;
  acknowledged_.set(proxy.place, through);
  if (!proxy.timeliness.is_late()) in_time_.set(proxy.place_in_time, through);
}

void MatchedReaders::update_timeliness(SequenceNumber written, MonotonicTime now) {
  if (now < next_check_) return;
  next_check_ = now + kCheckPeriod;
  for (auto& [guid, proxy] : proxies_) {
    if (!proxy.acknowledges()) continue;
    proxy.timeliness.update(proxy.acknowledged(), written, now);
    if (proxy.timeliness.is_late())
      in_time_.remove(proxy.place_in_time);
    else
      in_time_.set(proxy.place_in_time, proxy.acknowledged());
  }
}

void MatchedReaders::count(const ReaderProxy& proxy, int by) {
  const auto add = [by](std::size_t& to, bool counts) {
    if (counts) to += static_cast<std::size_t>(by);
  };
  const auto& reader = proxy.reader();
  add(filtered_, proxy.is_filtered());
  add(bare_only_, reader.keys.bare_only);
  add(short_is_hash_, reader.keys.short_is_hash);
  if (by > 0)
    add_locators(proxy);
  else
    remove_locators(proxy);
}

}  // namespace ddssec::rtps
