#include "plugins/cyclonedds/session_resets.hpp"

#include <algorithm>
#include <utility>

#include "base/hash.hpp"

namespace ddssec::cyclonedds {

SessionResets& SessionResets::of_process() {
  static auto& resets =
      *new SessionResets;  // never destroyed, because authentication's timer may ask at exit
  return resets;
}

void SessionResets::expect(ResetPair pair, spi::IdentityHandle identity,
                           spi::ResetToken token) noexcept {
  const std::lock_guard lock(mutex_);
  try {
    sessions_.try_emplace(token.name, Session{pair, identity, std::move(token.proof)});
  } catch (...) {
    // As declared, nothing is recorded if memory runs out.
  }
}

void SessionResets::forget(spi::ParticipantCryptoHandle participant) {
  const std::lock_guard lock(mutex_);
  std::erase_if(sessions_, [&](const auto& entry) {
    const auto& [pair, identity, proof, is_lost] = entry.second;
    if (pair.peer != participant && pair.local != participant) return false;
    if (is_lost) --lost_;
    return true;
  });
}

bool SessionResets::note_reset(const spi::Reset& reset) {
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

SessionReset SessionResets::take(spi::IdentityHandle identity, const PeersWithKeys& peers) {
  if (lost_.load(std::memory_order_relaxed) == 0) return SessionReset::none;
  const std::lock_guard lock(mutex_);
  bool is_lost = false, was_used = !peers.has_sent_keys(identity);
  for (auto& [name, session] : sessions_)
    if (session.identity == identity && std::exchange(session.is_lost, false)) {
      --lost_;
      is_lost = true;
      was_used = was_used || peers.has_sent_keys(session.pair.peer, session.pair.local);
    }
  if (!is_lost) return SessionReset::none;
  return was_used ? SessionReset::of_session : SessionReset::of_unused_session;
}

}  // namespace ddssec::cyclonedds
