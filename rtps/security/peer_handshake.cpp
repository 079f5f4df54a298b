#include "rtps/security/peer_handshake.hpp"

#include <algorithm>

#include "rtps/wire/entity_ids.hpp"

namespace ddssec::rtps {
namespace {

bool ends_with(const spi::Token& token, std::string_view suffix) {
  return token.class_id.ends_with(suffix);
}

}  // namespace

PeerHandshake::PeerHandshake(spi::Authentication& plugin, Sides sides,
                             std::shared_ptr<const Bytes> own_data, MessageNumbers& numbers,
                             MonotonicTime now)
    : plugin_(plugin),
      sides_(std::move(sides)),
      own_data_(std::move(own_data)),
      numbers_(numbers),
      give_up_(now + kGiveUp),
      next_(now + kDelay),
      budget_(kBurst, kRefill, now) {}

PeerHandshake::~PeerHandshake() {
  if (peer_) static_cast<void>(plugin_.return_identity_handle(peer_));
}

spi::HandshakeHandle PeerHandshake::handle() const {
  const auto* finished = std::get_if<Finished>(&state_);
  return finished != nullptr ? finished->handle : spi::HandshakeHandle{};
}

GenericMessage PeerHandshake::message_of(std::string_view message_class, spi::Token token,
                                         const MessageIdentity& related) {
  GenericMessage message;
  message.identity = {{sides_.own_guid.prefix, kStatelessMessageWriter}, numbers_.next()};
  message.related = related;
  message.destination_participant = sides_.peer_guid;
  message.message_class = message_class;
  message.data.push_back(std::move(token));
  return message;
}

void PeerHandshake::fail_with(Error error) {
  failure_ = std::move(error);
  next_ = kNever;
}

void PeerHandshake::start(MonotonicTime now, Messages& out) {
  // The peer's own auth_request is not handed over: whoever forges one could otherwise shut out the
  // honest peer, and nothing but its signatures proves anything.
  auto peer = plugin_.validate_remote_identity(sides_.own, std::nullopt, sides_.peer_identity_token,
                                               sides_.peer_guid);
  if (!peer) return fail_with(peer.error());
  peer_ = peer->handle;
  if (peer->local_auth_request && sides_.send_auth_request) {
    auth_request_ = message_of(message_class::kAuthRequest, *peer->local_auth_request, {});
    out.push_back(*auth_request_);
  }
  if (peer->result != spi::ValidationResult::pending_handshake_request) {
    state_ = Awaiting{};
  } else {
    auto step = plugin_.begin_handshake_request(sides_.own, peer_, *own_data_);
    if (!step) return fail_with(step.error());
    auto request = message_of(message_class::kAuthentication, std::move(*step->message), {});
    out.push_back(request);
    state_ = Requesting{step->handle, std::move(request)};
  }
  next_ = now + kResend;
}

void PeerHandshake::tick(MonotonicTime now, Messages& out) {
  if (now < next_) return;
  if (now >= give_up_)
    return fail_with(Error(Code::rtps_authentication_timeout,
                           {.expected = "a finished handshake within 100 s"}));
  if (std::holds_alternative<Starting>(state_)) return start(now, out);
  next_ = now + kResend;
  if (const auto* requesting = std::get_if<Requesting>(&state_)) {
    out.push_back(requesting->request);
  } else if (const auto* awaiting = std::get_if<Awaiting>(&state_)) {
    for (const auto& answer : awaiting->answers) out.push_back(answer.reply);
    if (awaiting->answers.empty() && auth_request_) out.push_back(*auth_request_);
  }
}

void PeerHandshake::receive(const GenericMessage& message, MonotonicTime now, Messages& out) {
  if (message.data.size() != 1 || failure_) return;
  if (std::holds_alternative<Starting>(state_)) start(now, out);
  // Every message costs public-key work before it can be told from a forged one.
  if (failure_ || !budget_.take(now)) return;
  const auto& token = message.data.front();
  if (ends_with(token, "+Req"))
    on_request(message, out);
  else if (ends_with(token, "+Reply"))
    on_reply(message, out);
  else if (ends_with(token, "+Final"))
    on_final(message);
}

// awaiting --Req--> awaiting, with one more answer or the same one again
void PeerHandshake::on_request(const GenericMessage& message, Messages& out) {
  if (!std::holds_alternative<Awaiting>(state_)) return;
  auto step = plugin_.begin_handshake_reply(message.data.front(), peer_, sides_.own, *own_data_);
  refusals_ += step ? 0 : 1;
  if (step && step->message) answer(std::move(*step), message.identity, out);
}

void PeerHandshake::answer(spi::Authentication::HandshakeStep step, const MessageIdentity& to,
                           Messages& out) {
  auto& answers = std::get<Awaiting>(state_).answers;
  const auto known = std::ranges::find(answers, step.handle, &Answer::handle);
  if (known != answers.end()) {
    known->reply.related = to;  // Cyclone DDS numbers its repetitions anew
    out.push_back(known->reply);
    return;
  }
  if (answers.size() >= kMostAnswers) answers.erase(answers.begin());
  answers.push_back(
      {step.handle, message_of(message_class::kAuthentication, std::move(*step.message), to)});
  out.push_back(answers.back().reply);
}

// requesting --Reply--> finished; finished --Reply--> finished, with the Final again
void PeerHandshake::on_reply(const GenericMessage& message, Messages& out) {
  const auto* requesting = std::get_if<Requesting>(&state_);
  auto* finished = std::get_if<Finished>(&state_);
  if (requesting == nullptr && (finished == nullptr || !finished->final)) return;
  const auto handle = requesting != nullptr ? requesting->handle : finished->handle;
  auto step = plugin_.process_handshake(handle, message.data.front());
  refusals_ += step ? 0 : 1;
  if (!step || step->result != spi::ValidationResult::ok_final_message || !step->message) return;
  if (finished != nullptr) {
    finished->final->related = message.identity;
    return out.push_back(*finished->final);
  }
  auto final =
      message_of(message_class::kAuthentication, std::move(*step->message), message.identity);
  out.push_back(final);
  state_ = Finished{handle, std::move(final)};
  next_ = kNever;
}

// awaiting --Final--> finished, by whichever answer it belongs to
void PeerHandshake::on_final(const GenericMessage& message) {
  const auto* awaiting = std::get_if<Awaiting>(&state_);
  if (awaiting == nullptr) return;
  for (const auto& answer : awaiting->answers) {
    const auto handle = answer.handle;
    const auto step = plugin_.process_handshake(handle, message.data.front());
    if (!step || step->result != spi::ValidationResult::ok) continue;
    state_ = Finished{handle, std::nullopt};
    next_ = kNever;
    return;
  }
  ++refusals_;
}

}  // namespace ddssec::rtps
