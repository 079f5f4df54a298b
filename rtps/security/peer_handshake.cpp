#include "rtps/security/peer_handshake.hpp"

#include <algorithm>

#include "wire/entity_ids.hpp"

namespace ddssec::rtps {
namespace {

constexpr int kMaxDoublings = 5;

using Kind = spi::Authentication::Outline::Kind;

Bytes octets_of(const spi::Token& token, std::string_view name) {
  const auto* found = spi::find_binary_property(token, name);
  return found != nullptr ? *found : Bytes();
}

Sha256Digest digest_of(const spi::Token& token) {
  Writer out;
  spi::write_token(out, token);
  return sha256(out.view());
}

}  // namespace

PeerHandshake::PeerHandshake(spi::Authentication& plugin, Sides sides,
                             std::shared_ptr<const Bytes> own_data, HandshakeAccount& account,
                             MonotonicTime now)
    : plugin_(plugin),
      sides_(std::move(sides)),
      own_data_(std::move(own_data)),
      account_(account),
      overdue_at_(now + kOverdue),
      next_(now + kDelay),
      answers_(plugin, account.answer_octets) {}

spi::HandshakeHandle PeerHandshake::handle() const {
  return finished_ ? finished_->handle : spi::HandshakeHandle{};
}

GenericMessage PeerHandshake::message_of(std::string_view message_class, spi::Token token,
                                         const MessageIdentity& related) {
  GenericMessage message;
  message.identity = {{sides_.own_guid.prefix, kStatelessMessageWriter}, ++account_.last_number};
  message.related = related;
  message.destination_participant = sides_.peer_guid;
  message.message_class = message_class;
  message.data.push_back(std::move(token));
  return message;
}

// ---- time

void PeerHandshake::start(MonotonicTime now, Messages& out) {
  if (now < refused_until_) return;
  // The peer's own auth_request is not passed to the plugin. It proves nothing, because only
  // signatures do, and a forged one could shut out the honest peer.
  auto peer = plugin_.validate_remote_identity(sides_.own, std::nullopt, sides_.peer_identity_token,
                                               sides_.peer_guid);
  if (!peer && spi::refusal_passes(peer.error().code())) {
    next_ = refused_until_ = now + (now < overdue_at_ ? kResend : kSlow);
    return;
  }
  is_started_ = true;
  began_ = now;
  if (!peer) {
    failure_ = peer.error();
    next_ = kNever;
    return;
  }
  const auto& known = sides_.known_identity;
  identity_ = known && known->handle() == peer->handle
                  ? known
                  : std::make_shared<const PeerIdentity>(plugin_, peer->handle);
  if (peer->local_auth_request)
    auth_request_ = message_of(message_class::kAuthRequest, *peer->local_auth_request, {});
  if (const auto own = auth_request()) out.push_back(*own);
  next_ = now + pause();
  if (is_initiator() && make_request(kNever)) out.push_back(request_->message);
}

bool PeerHandshake::make_request(MonotonicTime until) {
  auto step = plugin_.begin_handshake_request(sides_.own, identity_->handle(), *own_data_);
  if (!step) {
    const bool passes = step.error().code() == Code::too_many_handshakes ||
                        spi::refusal_passes(step.error().code());
    if (finished_ || passes) return false;  // tick tries again if the refusal may pass
    failure_ = step.error();
    next_ = kNever;
    return false;
  }
  request_ =
      Request{step->handle,
              message_of(message_class::kAuthentication, std::move(*step->message), {}), until};
  return true;
}

// A silent peer is sent messages less and less often, because its address may belong to another
// machine.
MonotonicTime PeerHandshake::pause() {
  const auto round = repetitions_++;
  if (round == 0) return kFirstResend;
  if (is_overdue_) return kSlow;
  return was_heard_ ? kResend
                    : std::min(kResend * (1 << std::min(round - 1, kMaxDoublings)), kSlow);
}

void PeerHandshake::tick(MonotonicTime now, Messages& out) {
  if (now < next_) return;
  last_sent_ = now;
  if (!is_started_) return start(now, out);
  if (!finished_ && now >= overdue_at_) become_overdue(now);
  answers_.expire(now);
  if (request_ && now >= request_->until) {
    static_cast<void>(plugin_.return_handshake_handle(request_->handle));
    request_.reset();
  }
  if (is_initiator() && !request_ && !finished_) make_request(kNever);
  if (failure_) return;
  if (request_) out.push_back(request_->message);
  answers_.repeat(out);
  const auto own = auth_request();
  const bool waits = !is_initiator() && !finished_ && own;
  if (waits && (answers_.empty() || std::exchange(has_shorter_delays_, false))) out.push_back(*own);
  next_ = finished_ && !request_ && answers_.empty() ? kNever : now + pause();
  if (!finished_) next_ = std::min(next_, overdue_at_);
}

// All messages may have been lost, or replaced by messages of a third party; neither proves
// anything about the peer. The plugin may have dropped the local request, so it is created again.
void PeerHandshake::become_overdue(MonotonicTime now) {
  is_overdue_ = true;
  overdue_at_ = now + kOverdue;
  if (!request_) return;
  static_cast<void>(plugin_.return_handshake_handle(request_->handle));
  request_.reset();
  make_request(kNever);
}

void PeerHandshake::repeat_by(MonotonicTime time) {
  if (is_started_ && !finished_ && !failure_) next_ = std::min(next_, time);
}

void PeerHandshake::note_sign(MonotonicTime now) {
  repeat_by(std::max<MonotonicTime>(now, last_sent_ + kSignPause));
}

void PeerHandshake::shorten_delays(MonotonicTime now) {
  if (!is_started_ || failure_) return;
  has_shorter_delays_ = true;
  if (next_ != kNever) next_ = std::min(next_, std::max(now, began_ + kDelay));
}

void PeerHandshake::begin_again(MonotonicTime now) {
  if (!is_initiator() || !finished_ || request_ || !make_request(now + kSecondTry)) return;
  next_ = now;
}

// ---- messages

// Only the side that begins sends more than it received, so it must know that the peer receives its
// messages. The other side answers each challenge, whatever else the message repeats: it may be the
// only message that arrives.
Bytes PeerHandshake::receive_auth_request(const GenericMessage& message, Messages& out) {
  constexpr std::size_t kMaxChallenge = 64;
  if (message.data.size() != 1) return {};
  const auto& token = message.data.front();
  auto challenge = octets_of(token, kChallenge);
  if (!challenge.empty() && challenge.size() <= kMaxChallenge) {
    heard_challenge_ = std::move(challenge);
    note_repeats_challenges();
    const auto own = auth_request();
    if (!is_initiator() && own) out.push_back(*own);
  }
  return octets_of(token, kHeardChallenge);
}

std::optional<GenericMessage> PeerHandshake::auth_request() const {
  auto out = auth_request_;
  if (!sides_.send_auth_request && !repeats_challenges()) return {};
  if (out && !heard_challenge_.empty())
    out->data.front().binary_properties.push_back({std::string(kHeardChallenge), heard_challenge_});
  return out;
}

PeerHandshake::Assessment PeerHandshake::assess(const GenericMessage& message) const {
  if (message.data.size() != 1 || failure_) return {};
  const auto& token = message.data.front();
  const auto outline = plugin_.outline(token);
  if (is_initiator())
    return outline.kind == Kind::reply ? assess_reply(token, outline) : Assessment{};
  if (outline.kind == Kind::request) return assess_request(token);
  const bool is_echo = outline.kind == Kind::final && !answers_.answered_by(outline).empty();
  return {is_echo ? Effort::echo : Effort::none};
}

PeerHandshake::Assessment PeerHandshake::assess_reply(
    const spi::Token& token, const spi::Authentication::Outline& outline) const {
  const bool is_echo =
      request_ && !outline.challenge1.empty() &&
      std::ranges::equal(outline.challenge1,
                         plugin_.outline(request_->message.data.front()).challenge1);
  if (!is_echo && !finished_) return {};
  const auto digest = digest_of(token);
  if (is_echo) return {Effort::echo, digest};
  return {finished_->last == digest ? Effort::memory : Effort::none, digest};
}

PeerHandshake::Assessment PeerHandshake::assess_request(const spi::Token& token) const {
  const auto digest = digest_of(token);
  if (finished_ && finished_->last == digest) return {};  // the request arrives late
  const bool known = std::ranges::count(answers_.all(), digest, &HandshakeAnswer::request) > 0;
  return {known ? Effort::memory : Effort::request, digest};
}

bool PeerHandshake::receive(const GenericMessage& message, const Assessment& assessment,
                            MonotonicTime now, Messages& out) {
  const auto& [needed, digest] = assessment;
  if (needed == Effort::none) return true;
  was_heard_ = true;
  if (!is_started_) start(now, out);
  if (failure_ || !is_started_) return true;
  if (needed == Effort::memory) {
    repeat_known(message, digest, out);
    return true;
  }
  if (needed == Effort::request) return on_request(message, digest, now, out);
  if (is_initiator())
    on_reply(message, digest, out);
  else
    on_final(message);
  return true;
}

// Cyclone DDS assigns new numbers to its repetitions, so the answer refers to the number of this
// one.
void PeerHandshake::repeat_known(const GenericMessage& message, const Sha256Digest& digest,
                                 Messages& out) {
  if (is_initiator()) {
    finished_->final->related = message.identity;
    return out.push_back(*finished_->final);
  }
  auto* answer = answers_.to(digest);
  answer->reply.related = message.identity;
  out.push_back(answer->reply);
}

// Adds one more answer to the others.
bool PeerHandshake::on_request(const GenericMessage& message, const Sha256Digest& digest,
                               MonotonicTime now, Messages& out) {
  const auto& token = message.data.front();
  const auto outline = plugin_.outline(token);
  auto challenge = to_bytes(outline.challenge1);
  if (!answers_.make_room(challenge, now)) return false;
  auto step = plugin_.begin_handshake_reply(token, identity_->handle(), sides_.own, *own_data_);
  refusals_ += step ? 0 : 1;
  if (!step || !step->message) return true;
  // A request with the same content in another form already has an answer.
  if (auto* known = answers_.with(step->handle)) {
    known->reply.related = message.identity;
    out.push_back(known->reply);
    return true;
  }
  auto reply =
      message_of(message_class::kAuthentication, std::move(*step->message), message.identity);
  out.push_back(reply);
  answers_.add({.handle = step->handle,
                .reply = std::move(reply),
                .request = digest,
                .challenge = std::move(challenge),
                .peer_data = to_bytes(outline.participant_data),
                .since = now,
                .octets = spi::binary_octets(token)});
  next_ = std::min(next_, now + kResend);
  return true;
}

void PeerHandshake::on_reply(const GenericMessage& message, const Sha256Digest& digest,
                             Messages& out) {
  const auto& token = message.data.front();
  auto step = plugin_.process_handshake(request_->handle, token);
  refusals_ += step ? 0 : 1;
  if (!step || step->result != spi::ValidationResult::ok_final_message || !step->message) return;
  auto final =
      message_of(message_class::kAuthentication, std::move(*step->message), message.identity);
  out.push_back(final);
  const auto handle = request_->handle;
  request_.reset();
  finish({handle, digest, std::move(final)}, to_bytes(plugin_.outline(token).participant_data));
}

// Uses the answer that the final message belongs to.
void PeerHandshake::on_final(const GenericMessage& message) {
  const auto& token = message.data.front();
  for (const auto* answer : answers_.answered_by(plugin_.outline(token))) {
    const auto step = plugin_.process_handshake(answer->handle, token);
    if (!step || step->result != spi::ValidationResult::ok) continue;
    const FinishedHandshake finished{answer->handle, answer->request, std::nullopt};
    auto peer_data = answer->peer_data;
    answers_.finish(finished.handle);
    return finish(finished, std::move(peer_data));
  }
  ++refusals_;
}

void PeerHandshake::finish(FinishedHandshake finished, Bytes peer_data) {
  if (finished_) static_cast<void>(plugin_.return_handshake_handle(finished_->handle));
  finished_ = std::move(finished);
  peer_data_ = std::move(peer_data);
  has_new_proof_ = true;
  next_ = kNever;
}

}  // namespace ddssec::rtps
