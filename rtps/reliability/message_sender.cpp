#include "rtps/reliability/message_sender.hpp"

#include <algorithm>

namespace ddssec::rtps {
namespace {

bool is_wrapped(SendProtection::Wrap wrap) { return wrap != SendProtection::Wrap::none; }

}  // namespace

MessageSender::MessageSender(Transport& transport, const GuidPrefix& prefix)
    : transport_(transport), out_(slot(0)) {
  header_.prefix = prefix;
}

void MessageSender::protect_with(SendProtection& protection) {
  protection_ = &protection;
  for (auto* buffer : {&buffer_, &payload_, &plain_}) buffer->resize(kMaxDatagram);
  slot_size_ = kMaxDatagram;
  out_ = SpanWriter(slot(0));
}

bool MessageSender::leaves_time_unprotected(const EntityId& writer) const {
  if (protection_ == nullptr || is_builtin(writer)) return false;
  const auto levels = protection_->levels(writer);
  return levels.submessage && levels.message != SendProtection::Wrap::participant_key;
}

bool MessageSender::protects_payload(const EntityId& writer) const {
  return protection_ != nullptr && !is_builtin(writer) && protection_->levels(writer).payload;
}

std::size_t MessageSender::fragments_left(const Destination& to) {
  return limit_.left(to.charged.is_zero() ? to.prefix : to.charged, to.locators) / fragment_size_;
}

void MessageSender::begin(const Destination& to, const SendProtection::Levels& levels) {
  const auto wrap = levels.message;
  const auto& charged = to.charged.is_zero() ? to.prefix : to.charged;
  const auto limited = limit_.is_limited(charged) ? charged : GuidPrefix{};
  const bool other = !std::ranges::equal(to.locators, to_) || wrap != wrap_ || to.dscp != dscp_ ||
                     to.interface != interface_ || limited != limited_;
  if (other && (out_.size() > 0 || waiting_ > 0))
    flush_now();
  else if (out_.size() >= full_size_)
    finish_message();
  const bool empty = out_.size() == 0;
  if (other) to_.assign(to.locators.begin(), to.locators.end());
  if (empty) begin_message(to_, levels);
  // An INFO_DST applies until the next one or the end of the message.
  if ((empty && !to.prefix.is_zero()) || (!empty && to.prefix != destination_))
    write(out_, InfoDestination{to.prefix});
  receiver_ = empty || to.prefix == receiver_ ? to.prefix : GuidPrefix{};
  destination_ = to.prefix;
  dscp_ = to.dscp;
  interface_ = to.interface;
  limited_ = limited;
  wrap_ = wrap;
}

void MessageSender::begin_message(std::span<const Locator> to,
                                  const SendProtection::Levels& levels) {
  const bool here =
      std::ranges::all_of(to, [&](const auto& locator) { return transport_.stays_here(locator); });
  if (here && protection_ == nullptr) slot_size_ = kMaxDatagram;
  const bool wrapped = is_wrapped(levels.message);
  auto room = protection_ != nullptr || here ? kMaxDatagram : kMaxMessage;
  if (wrapped) room -= std::min(room / 2, levels.message_room);
  full_size_ = !here ? kMaxMessage : protection_ != nullptr ? kFullProtected : room;
  out_ = SpanWriter((wrapped ? MutableBytes(buffer_) : slot(waiting_)).first(room));
  write(out_, header_);
}

// A payload that is signed without its length must end on a 4-octet boundary (DDS-Security 1.2,
// clause 10.5.3.3.4.3).
std::optional<BytesView> MessageSender::protected_payload(const EntityId& writer, BytesView plain) {
  if (plain.size() % 4 != 0) {
    SpanWriter padded(plain_);
    padded.write_bytes(plain);
    padded.align(4);
    if (padded.overflowed()) return std::nullopt;
    plain = padded.view();
  }
  const auto size = protection_->protect_payload(writer, plain, payload_);
  if (size) return BytesView(payload_).first(*size);
  protection_->on_unprotectable(size.error());
  return std::nullopt;
}

bool MessageSender::write_protected_submessage(const EntityId& sender, const Guid& receiver,
                                               BytesView plain) {
  const auto size = protection_->protect_submessage(sender, receiver, plain, out_.spare());
  if (size) {
    out_.commit(*size);
    return true;
  }
  const bool first = out_.size() <= kHeaderSize + 16;
  if (size.error().code() == Code::length_out_of_range && !first) {
    out_.overflow();
    return true;
  }
  protection_->on_unprotectable(size.error());
  return false;
}

MutableBytes MessageSender::slot(std::size_t index) {
  auto& octets = slots_[index];
  if (octets.size() < slot_size_) octets.resize(slot_size_);
  return octets;
}

void MessageSender::finish_message() {
  const bool any = out_.size() > kHeaderSize && !out_.overflowed();
  if (any && is_wrapped(wrap_)) {
    const auto out = slot(waiting_);
    const auto size = protection_->protect_message(wrap_, receiver_, out_.view(), out);
    if (size)
      wait_for_more(out.first(*size));
    else
      protection_->on_unprotectable(size.error());
  } else if (any) {
    wait_for_more(out_.view());
  }
  out_.rewind(0);
  if (waiting_ == kMaxWaiting || waiting_octets_ + full_size_ > kMaxWaitingOctets) send_waiting();
}

void MessageSender::wait_for_more(BytesView message) {
  messages_[waiting_++] = message;
  waiting_octets_ += message.size();
}

void MessageSender::send_waiting() {
  const OutgoingMessages out{std::span(messages_).first(waiting_), to_, dscp_, interface_};
  if (!limited_.is_zero())
    send_limited(out);
  else if (waiting_ > 0)
    transport_.send_all(out);
  waiting_ = 0;
  waiting_octets_ = 0;
}

void MessageSender::send_limited(const OutgoingMessages& out) {
  for (const auto& message : out.messages) {
    const auto to = limit_.charge(limited_, message.size(), out.to);
    if (!to.empty()) transport_.send_all({{&message, 1}, to, out.dscp, out.interface});
  }
}

void MessageSender::flush() {
  if (gatherings_ == 0)
    flush_now();
  else
    is_flush_wanted_ = true;
}

// If memory runs out, the next flush tries again.
void MessageSender::flush_at_end() noexcept {
  try {
    flush_now();
  } catch (...) {
    is_flush_wanted_ = true;
  }
}

void MessageSender::flush_now() {
  finish_message();
  send_waiting();
  flush_by_ = kNever;
  is_flush_wanted_ = false;
}

}  // namespace ddssec::rtps
