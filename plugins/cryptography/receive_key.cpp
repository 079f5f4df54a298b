#include "plugins/cryptography/receive_key.hpp"

#include <algorithm>

namespace ddssec::cryptography {

void NewestPosition::note(const NewestPosition& other, RetiredObjects& retired_objects) {
  const auto& position = other.newest_.read()->position;
  if (position.is_after(newest_.read()->position))
    newest_.replace(std::make_unique<Place>(position), retired_objects);
}

void ReceiveKey::count_with(const std::shared_ptr<NewestPosition>& of_other) {
  if (!position_ || !of_other) return;
  of_other->note(*position_, services_.retired_objects);
  position_ = of_other;
}

Result<ReceiveKey::Candidate> ReceiveKey::session(SessionId id) {
  Candidate candidate;
  for (const auto& one : sessions_) {
    auto* const session = one.read();
    if (session == nullptr || session->id != id) continue;
    const auto now = time_.load(std::memory_order_relaxed);
    if (session->last_used.load(std::memory_order_relaxed) != now)
      session->last_used.store(now, std::memory_order_relaxed);
    candidate.session_ = session;
    return candidate;
  }
  auto fresh = blank();
  fresh->id = id;
  const auto key = derive_session_key(material_.sender_key, material_.salt, id);
  DDSSEC_RETURN_IF_ERROR(key.expose(
      [&](BytesView octets) { return fresh->key.expand(services_.aead, traits_.cipher, octets); }));
  if (material_.has_receiver_key()) {
    const auto receiver = derive_session_receiver_key(material_.receiver_key, material_.salt, id);
    DDSSEC_RETURN_IF_ERROR(receiver.expose([&](BytesView octets) {
      return fresh->receiver->expand(services_.aead, traits_.cipher, octets);
    }));
  }
  candidate.session_ = fresh.get();
  candidate.fresh_ = std::move(fresh);
  return candidate;
}

std::unique_ptr<ReceiveSession> ReceiveKey::blank() {
  {
    const std::lock_guard lock(mutex_);
    if (aside_.session && is_safe(aside_.epoch)) return std::move(aside_.session);
  }
  auto session = std::make_unique<ReceiveSession>();
  if (material_.has_receiver_key()) session->receiver = std::make_unique<ExpandedKey>();
  return session;
}

PublishedPointer<ReceiveSession>& ReceiveKey::place_for_next() {
  const auto now = time_.load(std::memory_order_relaxed);
  // Unsigned differences order the uses even when the counter wraps. An empty place is oldest.
  return *std::ranges::max_element(sessions_, {}, [&](const auto& one) -> std::uint64_t {
    const auto* const session = one.read();
    if (session == nullptr) return std::uint64_t{1} << 32;
    return now - session->last_used.load(std::memory_order_relaxed);
  });
}

void ReceiveKey::remember(Candidate candidate) {
  if (!candidate.fresh_) [[likely]]
    return;
  const std::lock_guard lock(mutex_);
  const auto id = candidate.fresh_->id;
  const bool known = std::ranges::any_of(
      sessions_, [&](const auto& one) { return one.read() != nullptr && one.read()->id == id; });
  if (known) return;  // another thread was faster
  const auto now = time_.fetch_add(1, std::memory_order_relaxed) + 1;
  candidate.fresh_->last_used.store(now, std::memory_order_relaxed);
  auto former = place_for_next().exchange(std::move(candidate.fresh_));
  if (!former) return;
  const auto epoch = retirement_epoch();
  if (aside_.session) services_.retired_objects.retire(std::move(aside_.session));
  aside_ = {std::move(former), epoch};
}

}  // namespace ddssec::cryptography
