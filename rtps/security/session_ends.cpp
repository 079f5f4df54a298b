#include "rtps/security/session_ends.hpp"

#include <algorithm>

#include "base/hash.hpp"

namespace ddssec::rtps {

void SessionEnds::expect(const GuidPrefix& peer, const spi::SharedSecret& secret) {
  sessions_.insert_or_assign(peer, Session{spi::derive_reset_token(secret, peer)});
}

void SessionEnds::note_reset(const GuidPrefix& peer, const spi::Reset& reset, MonotonicTime now) {
  const auto session = sessions_.find(peer);
  if (session == sessions_.end() || session->second.ended) return;
  const auto& expected = session->second.expected;
  const bool is_proven =
      std::ranges::equal(reset.name, expected.name) && expected.proof.expose([&](BytesView proof) {
        return constant_time_equal(proof, reset.proof);
      });
  if (!is_proven) return;
  session->second.ended = now;
  was_proven_ = true;
  if (on_proven_) on_proven_(peer, now);
}

bool SessionEnds::has_ended(const GuidPrefix& peer) const {
  const auto session = sessions_.find(peer);
  return session != sessions_.end() && session->second.ended;
}

bool SessionEnds::remove_if_before(const GuidPrefix& peer, MonotonicTime time) {
  const auto session = sessions_.find(peer);
  if (session == sessions_.end() || !session->second.ended || *session->second.ended >= time)
    return false;
  return !std::exchange(session->second.was_taken, true);
}

}  // namespace ddssec::rtps
