#include "plugins/authentication/unproven_octets.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "base/bytes.hpp"

namespace ddssec::authentication {
namespace {

// Returns a random number below `end`, or 0 if there is no randomness.
std::size_t random_below(std::size_t end, Random& random) {
  std::array<std::uint8_t, 4> octets{};
  if (!random.fill(octets)) return 0;
  std::size_t number = 0;
  for (const auto octet : octets) number = number << 8 | octet;
  return number % end;
}

}  // namespace

UnprovenOctets::Share UnprovenOctets::claim(const Sha256Digest& subject, std::size_t octets,
                                            std::size_t free_octets) {
  if (octets + free_octets <= kFreeOfAPeer) return Share(octets);
  const std::scoped_lock lock(mutex_);
  auto& of_subject = by_subject_[subject];
  const auto id = ++last_id_;
  entries_.emplace(id, Entry{subject, octets});
  of_subject += octets;
  total_ += octets;
  return Share(*this, id, octets);
}

void UnprovenOctets::note_owner(std::uint64_t id, spi::HandshakeHandle owner) noexcept {
  const std::scoped_lock lock(mutex_);
  if (const auto entry = entries_.find(id); entry != entries_.end()) entry->second.owner = owner;
}

void UnprovenOctets::uncount(Entry& entry) noexcept {
  if (!std::exchange(entry.is_counted, false)) return;
  total_ -= entry.octets;
  const auto known = by_subject_.find(entry.subject);
  known->second -= entry.octets;
  if (known->second == 0) by_subject_.erase(known);
}

void UnprovenOctets::release(std::uint64_t id) noexcept {
  const std::scoped_lock lock(mutex_);
  const auto entry = entries_.find(id);
  if (entry == entries_.end()) return;
  uncount(entry->second);
  entries_.erase(entry);
}

// Each entry is equally likely, so the effort of an attacker to hit a certain entry does not depend
// on the size of the attacker's requests.
UnprovenOctets::Entry* UnprovenOctets::any_of(Random& random, spi::HandshakeHandle newest,
                                              const Sha256Digest* subject) {
  std::vector<Entry*> all;
  for (auto& [id, entry] : entries_)
    if (entry.is_counted && entry.owner && entry.owner != newest &&
        (subject == nullptr || entry.subject == *subject))
      all.push_back(&entry);
  return all.empty() ? nullptr : all[random_below(all.size(), random)];
}

std::vector<spi::HandshakeHandle> UnprovenOctets::excess(Random& random,
                                                         spi::HandshakeHandle newest) {
  std::vector<spi::HandshakeHandle> out;
  const std::scoped_lock lock(mutex_);
  const auto own =
      std::ranges::find_if(entries_, [&](const auto& one) { return one.second.owner == newest; });
  if (own == entries_.end()) return out;
  const auto subject = own->second.subject;
  const auto drop_one = [&](const Sha256Digest* of) {
    auto* const entry = any_of(random, newest, of);
    if (entry == nullptr) return false;
    out.push_back(entry->owner);
    uncount(*entry);
    return true;
  };
  const auto of_subject = [&] {
    const auto known = by_subject_.find(subject);
    return known == by_subject_.end() ? 0 : known->second;
  };
  while (of_subject() > kMaxOfASubject && drop_one(&subject)) continue;
  while (total_ > kMax && drop_one(nullptr)) continue;
  return out;
}

}  // namespace ddssec::authentication
