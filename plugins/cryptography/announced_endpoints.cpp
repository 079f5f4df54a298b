#include "plugins/cryptography/announced_endpoints.hpp"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

#include "wire/entity_ids.hpp"

namespace ddssec::cryptography {
namespace {

std::unexpected<Error> too_much_announced_error(const DiscoveryTopic& topic) {
  return unreadable_name_error(topic, "its certificate has announced more than " +
                                          std::to_string(AnnouncedOctets::kMax >> 20) + " MiB");
}

bool hides_endpoint(const Announcement& announcement) {
  return announcement.kind == Announcement::Kind::announces && announcement.hides;
}

}  // namespace

bool AnnouncedOctets::replace(std::size_t before, std::size_t after, Heard heard) {
  const std::lock_guard lock(mutex_);
  auto& sum = sums_.at(std::to_underlying(heard));
  if (after > before && sum - before + after > kMax) return false;
  sum = sum - before + after;
  return true;
}

std::size_t AnnouncedOctets::sum(Heard heard) const {
  const std::lock_guard lock(mutex_);
  return sums_.at(std::to_underlying(heard));
}

std::shared_ptr<AnnouncedOctets> AnnouncementAccounts::of(SubjectId subject) {
  const std::lock_guard lock(mutex_);
  std::erase_if(accounts_, [](const auto& entry) { return entry.second.expired(); });
  auto& known = accounts_[subject];
  auto account = known.lock();
  if (!account) known = account = std::make_shared<AnnouncedOctets>();
  return account;
}

void SkippedNumbers::add(std::uint64_t begin, std::uint64_t end) {
  if (begin >= end) return;
  auto at = ranges_.upper_bound(begin);
  if (at != ranges_.begin() && std::prev(at)->second >= begin) --at;
  while (at != ranges_.end() && at->first <= end) {
    begin = std::min(begin, at->first);
    end = std::max(end, at->second);
    at = ranges_.erase(at);
  }
  ranges_.emplace(begin, end);
  if (ranges_.size() <= kMax) return;
  const auto first = ranges_.begin(), second = std::next(first);
  first->second = second->second;
  ranges_.erase(second);
}

bool SkippedNumbers::contains(std::uint64_t number) const {
  const auto after = ranges_.upper_bound(number);
  return after != ranges_.begin() && std::prev(after)->second > number;
}

void SkippedNumbers::forget_below(std::uint64_t number) {
  while (!ranges_.empty() && ranges_.begin()->second <= number) ranges_.erase(ranges_.begin());
}

AnnouncedEndpoints::~AnnouncedEndpoints() { leave_account(); }

void AnnouncedEndpoints::leave_account() {
  account_->replace(sum(), 0);
  account_->replace(sum_again(), 0, AnnouncedOctets::Heard::again);
}

std::size_t AnnouncedEndpoints::sum() const {
  std::size_t out = 0;
  for (const auto& [id, writer] : writers_) {
    for (const auto& [number, passed] : writer.passed) out += cost_of(passed);
    for (const auto& [entity, cost] : writer.endpoints) out += cost;
  }
  return out;
}

std::size_t AnnouncedEndpoints::sum_again() const {
  std::size_t out = 0;
  for (const auto& [id, writer] : writers_)
    for (const auto& [entity, cost] : writer.again) out += cost;
  return out;
}

std::size_t AnnouncedEndpoints::cost_of(const Announcement& announcement) {
  return announcement.octets + AnnouncedOctets::kOfEach;
}

void AnnouncedEndpoints::set_account(std::shared_ptr<AnnouncedOctets> account) {
  const std::lock_guard lock(mutex_);
  if (account == account_) return;
  leave_account();
  writers_.clear();
  account_ = std::move(account);
}

Status AnnouncedEndpoints::note(const DiscoveryTopic& topic, const Announcement& announcement) {
  const std::lock_guard lock(mutex_);
  auto& writer = writers_[topic.writer];
  if (announcement.number < writer.next) return note_again(topic, writer, announcement);
  const auto known = writer.passed.find(announcement.number);
  if (known != writer.passed.end())
    return known->second == announcement
               ? Status()
               : unreadable_name_error(topic, "something else came under its number before");
  if (!account_->replace(0, cost_of(announcement))) return too_much_announced_error(topic);
  writer.passed.emplace(announcement.number, announcement);
  note_announced(writer, announcement);
  return {};
}

void AnnouncedEndpoints::note_announced(Writer& writer, const Announcement& announcement) {
  writer.hides |= hides_endpoint(announcement);
  if (announcement.kind != Announcement::Kind::announces) return;
  if (!writer.announced.insert(announcement.entity).second) ++repeats_;
}

std::size_t AnnouncedEndpoints::take_repeats() {
  const std::lock_guard lock(mutex_);
  return std::exchange(repeats_, 0);
}

// A sample that the host has acknowledged is new only for a participant that was created later.
// For all others an attacker may repeat it, also after the endpoint has ended. If it ends an
// endpoint, nothing changes, because the host may have skipped it.
Status AnnouncedEndpoints::note_again(const DiscoveryTopic& topic, Writer& writer,
                                      const Announcement& announcement) {
  if (announcement.kind != Announcement::Kind::announces) return {};
  const auto known = writer.again.find(announcement.entity);
  const auto counted = known == writer.again.end() ? 0 : known->second;
  const auto cost = std::max(counted, cost_of(announcement));
  if (!account_->replace(counted, cost, AnnouncedOctets::Heard::again))
    return too_much_announced_error(topic);
  writer.again.insert_or_assign(announcement.entity, cost);
  writer.hides |= hides_endpoint(announcement);
  return {};
}

Status AnnouncedEndpoints::complete(const DiscoveryTopic& topic, const Announcement& announcement) {
  const std::lock_guard lock(mutex_);
  auto& writer = writers_[topic.writer];
  const auto known = writer.passed.find(announcement.number);
  if (known == writer.passed.end()) return note_again(topic, writer, announcement);
  known->second = announcement;
  note_announced(writer, announcement);
  return {};
}

bool AnnouncedEndpoints::hides(const EntityId& writer) const {
  const auto known = writers_.find(writer);
  return known != writers_.end() && known->second.hides;
}

bool AnnouncedEndpoints::hides_writers() const {
  const std::lock_guard lock(mutex_);
  return hides(rtps::kPublicationsWriter) || hides(rtps::kPublicationsSecureWriter);
}

bool AnnouncedEndpoints::hides_readers() const {
  const std::lock_guard lock(mutex_);
  return hides(rtps::kSubscriptionsWriter) || hides(rtps::kSubscriptionsSecureWriter);
}

bool AnnouncedEndpoints::has_secured(const EntityId& endpoint, bool is_writer) const {
  const std::lock_guard lock(mutex_);
  const auto known =
      writers_.find(is_writer ? rtps::kPublicationsSecureWriter : rtps::kSubscriptionsSecureWriter);
  if (known == writers_.end()) return false;
  const auto& [id, writer] = *known;
  return writer.endpoints.contains(endpoint) || writer.again.contains(endpoint) ||
         std::ranges::any_of(writer.passed, [&](const auto& passed) {
           return passed.second.kind == Announcement::Kind::announces &&
                  passed.second.entity == endpoint;
         });
}

bool AnnouncedEndpoints::has_ended(const EntityId& endpoint, bool is_writer) const {
  const std::lock_guard lock(mutex_);
  const auto known =
      writers_.find(is_writer ? rtps::kPublicationsSecureWriter : rtps::kSubscriptionsSecureWriter);
  if (known == writers_.end()) return false;
  const auto& ended = known->second.ended;
  return std::ranges::find(ended, endpoint) != ended.end();
}

void AnnouncedEndpoints::retract(const DiscoveryTopic& topic, std::uint64_t number) {
  const std::lock_guard lock(mutex_);
  auto& passed = writers_[topic.writer].passed;
  const auto known = passed.find(number);
  if (known == passed.end() || known->second.kind != Announcement::Kind::unread) return;
  account_->replace(cost_of(known->second), 0);
  passed.erase(known);
}

void AnnouncedEndpoints::skip(const DiscoveryTopic& topic, std::uint64_t begin, std::uint64_t end) {
  const std::lock_guard lock(mutex_);
  auto& writer = writers_[topic.writer];
  writer.skipped.add(std::max(begin, writer.next), end);
}

void AnnouncedEndpoints::acknowledged(const DiscoveryTopic& topic, std::uint64_t next) {
  const std::lock_guard lock(mutex_);
  const auto known = writers_.find(topic.writer);
  if (known == writers_.end() || next <= known->second.next) return;
  auto& writer = known->second;
  writer.next = next;
  while (!writer.passed.empty() && writer.passed.begin()->first < next) {
    settle(writer, writer.passed.begin()->second);
    writer.passed.erase(writer.passed.begin());
  }
  writer.skipped.forget_below(next);
}

bool AnnouncedEndpoints::is_acknowledged(const DiscoveryTopic& topic, std::uint64_t number) const {
  const std::lock_guard lock(mutex_);
  const auto known = writers_.find(topic.writer);
  return known != writers_.end() && number < known->second.next;
}

// Counts the sample for its endpoint and no longer under its number. The sum never grows by this.
void AnnouncedEndpoints::settle(Writer& writer, const Announcement& announcement) {
  account_->replace(cost_of(announcement), 0);
  const auto known = writer.endpoints.find(announcement.entity);
  const auto before = known == writer.endpoints.end() ? 0 : known->second;
  // The host may have skipped or refused a smaller announcement, and then keeps the former one.
  if (announcement.kind == Announcement::Kind::announces)
    set(writer, announcement.entity, std::max(before, cost_of(announcement)));
  else if (announcement.kind == Announcement::Kind::ends &&
           !writer.skipped.contains(announcement.number))
    forget(writer, announcement.entity);
}

void AnnouncedEndpoints::forget(Writer& writer, const EntityId& entity) {
  set(writer, entity, 0);
  if (writer.announced.erase(entity) != 0) {
    if (writer.ended.size() >= kMaxEnded) writer.ended.pop_front();
    writer.ended.push_back(entity);
  }
  const auto known = writer.again.find(entity);
  if (known == writer.again.end()) return;
  account_->replace(known->second, 0, AnnouncedOctets::Heard::again);
  writer.again.erase(known);
}

void AnnouncedEndpoints::set(Writer& writer, const EntityId& entity, std::size_t cost) {
  auto& counted = writer.endpoints[entity];
  account_->replace(counted, cost);
  counted = cost;
  if (cost == 0) writer.endpoints.erase(entity);
}

}  // namespace ddssec::cryptography
