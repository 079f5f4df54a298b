#include "plugins/cyclonedds/session_resets.hpp"

#include <algorithm>
#include <utility>

#include "base/hash.hpp"
#include "base/rollback.hpp"

namespace ddssec::cyclonedds {

SessionResets& SessionResets::of_process() {
  static auto& resets =
      *new SessionResets;  // never destroyed: authentication's timer may ask at exit
  return resets;
}

void SessionResets::expect(spi::ParticipantCryptoHandle peer, spi::IdentityHandle identity,
                           spi::ResetToken token) noexcept {
  const std::lock_guard lock(mutex_);
  try {
    const auto name = token.name;
    if (!sessions_.try_emplace(name, Session{peer, identity, std::move(token.proof)}).second)
      return;
    Rollback forget([&] { sessions_.erase(name); });
    names_.emplace(peer.value, name);
    forget.release();
  } catch (...) {
    // As declared.
  }
}

void SessionResets::forget(spi::ParticipantCryptoHandle peer) {
  const std::lock_guard lock(mutex_);
  const auto [first, end] = names_.equal_range(peer.value);
  for (auto of_peer = first; of_peer != end; ++of_peer) {
    const auto session = sessions_.find(of_peer->second);
    if (session->second.is_lost) --lost_;
    sessions_.erase(session);
  }
  names_.erase(first, end);
}

bool SessionResets::received(const spi::Reset& reset) {
  spi::ResetName name{};
  std::ranges::copy(reset.name, name.begin());
  const std::lock_guard lock(mutex_);
  const auto session = sessions_.find(name);
  if (session == sessions_.end()) return false;
  const bool is_proven = session->second.proof.expose(
      [&](BytesView proof) { return constant_time_equal(proof, reset.proof); });
  if (is_proven && !std::exchange(session->second.is_lost, true)) ++lost_;
  return is_proven;
}

bool SessionResets::take(spi::IdentityHandle identity) {
  if (lost_.load(std::memory_order_relaxed) == 0) return false;
  const std::lock_guard lock(mutex_);
  bool is_lost = false;
  for (auto& [name, session] : sessions_)
    if (session.identity == identity && std::exchange(session.is_lost, false)) {
      --lost_;
      is_lost = true;
    }
  return is_lost;
}

}  // namespace ddssec::cyclonedds
