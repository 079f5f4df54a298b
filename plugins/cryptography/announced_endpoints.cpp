#include "plugins/cryptography/announced_endpoints.hpp"

#include <string>

namespace ddssec::cryptography {

bool AnnouncedOctets::replace(std::size_t before, std::size_t after) {
  const std::lock_guard lock(mutex_);
  if (after > before && sum_ - before + after > kMost) return false;
  sum_ = sum_ - before + after;
  return true;
}

std::size_t AnnouncedOctets::sum() const {
  const std::lock_guard lock(mutex_);
  return sum_;
}

std::shared_ptr<AnnouncedOctets> AnnouncementAccounts::of(std::uint64_t subject) {
  const std::lock_guard lock(mutex_);
  std::erase_if(accounts_, [](const auto& entry) { return entry.second.expired(); });
  auto& known = accounts_[subject];
  auto account = known.lock();
  if (!account) known = account = std::make_shared<AnnouncedOctets>();
  return account;
}

AnnouncedEndpoints::~AnnouncedEndpoints() { clear(); }

void AnnouncedEndpoints::clear() {
  for (const auto& [key, size] : sizes_) account_->replace(size, 0);
  sizes_.clear();
}

void AnnouncedEndpoints::count_for(std::shared_ptr<AnnouncedOctets> account) {
  const std::lock_guard lock(mutex_);
  if (account == account_) return;
  clear();
  account_ = std::move(account);
}

Status AnnouncedEndpoints::announce(const BuiltinTopic& topic, const EntityId& entity,
                                    std::size_t octets) {
  const std::lock_guard lock(mutex_);
  const Key key{topic.writer, entity};
  const auto known = sizes_.find(key);
  const auto before = known == sizes_.end() ? 0 : known->second;
  const auto after = octets + AnnouncedOctets::kOfEach;
  if (!account_->replace(before, after))
    return unreadable_name(topic, "its certificate has announced more than " +
                                      std::to_string(AnnouncedOctets::kMost >> 20) + " MiB");
  sizes_.insert_or_assign(key, after);
  return {};
}

void AnnouncedEndpoints::withdraw(const BuiltinTopic& topic, const EntityId& entity) {
  const std::lock_guard lock(mutex_);
  const auto known = sizes_.find({topic.writer, entity});
  if (known == sizes_.end()) return;
  account_->replace(known->second, 0);
  sizes_.erase(known);
}

}  // namespace ddssec::cryptography
