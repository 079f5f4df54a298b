#include "rtps/security/handshake_answers.hpp"

#include <algorithm>

namespace ddssec::rtps {
namespace {

bool same(BytesView a, BytesView b) { return !a.empty() && std::ranges::equal(a, b); }

}  // namespace

std::vector<const HandshakeAnswer*> HandshakeAnswers::answered_by(
    const spi::Authentication::Outline& final) const {
  std::vector<const HandshakeAnswer*> out;
  for (const auto& answer : answers_) {
    const auto reply = plugin_.outline(answer.reply.data.front());
    if (same(final.challenge1, reply.challenge1) && same(final.challenge2, reply.challenge2))
      out.push_back(&answer);
  }
  return out;
}

HandshakeAnswer* HandshakeAnswers::to(const Sha256Digest& request) {
  const auto at = std::ranges::find(answers_, request, &HandshakeAnswer::request);
  return at == answers_.end() ? nullptr : &*at;
}

HandshakeAnswer* HandshakeAnswers::with(spi::HandshakeHandle handle) {
  const auto at = std::ranges::find(answers_, handle, &HandshakeAnswer::handle);
  return at == answers_.end() ? nullptr : &*at;
}

bool HandshakeAnswers::make_room(const Bytes& challenge, MonotonicTime now) {
  const auto alike = std::ranges::count(answers_, challenge, &HandshakeAnswer::challenge);
  auto victim = answers_.end();
  if (static_cast<std::size_t>(alike) >= kMaxPerChallenge)
    victim = std::ranges::find(answers_, challenge, &HandshakeAnswer::challenge);
  else if (answers_.size() >= kMax)
    victim = answers_.begin();
  else
    return true;
  if (now - victim->since < kMinAge) return false;
  drop(victim);
  return true;
}

const HandshakeAnswer& HandshakeAnswers::add(HandshakeAnswer answer) {
  answer.octets += kPrice;
  octets_ += answer.octets;
  account_ += answer.octets;
  return answers_.emplace_back(std::move(answer));
}

void HandshakeAnswers::expire(MonotonicTime now) {
  while (!answers_.empty() && now - answers_.front().since >= kLife) drop(answers_.begin());
}

void HandshakeAnswers::evict_largest() {
  if (!answers_.empty()) drop(answers_.begin());
}

void HandshakeAnswers::finish(spi::HandshakeHandle handle) {
  const auto at = std::ranges::find(answers_, handle, &HandshakeAnswer::handle);
  if (at != answers_.end()) forget(at);
  while (!answers_.empty()) drop(answers_.begin());
}

void HandshakeAnswers::repeat(std::vector<GenericMessage>& out) {
  const auto count = std::min(answers_.size(), kMaxRepeated);
  for (std::size_t i = 0; i < count; ++i) out.push_back(answers_[next_++ % answers_.size()].reply);
}

void HandshakeAnswers::drop(std::vector<HandshakeAnswer>::iterator answer) {
  static_cast<void>(plugin_.return_handshake_handle(answer->handle));
  forget(answer);
}

void HandshakeAnswers::forget(std::vector<HandshakeAnswer>::iterator answer) {
  octets_ -= answer->octets;
  account_ -= answer->octets;
  answers_.erase(answer);
}

}  // namespace ddssec::rtps
