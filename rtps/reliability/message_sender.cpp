#include "rtps/reliability/message_sender.hpp"

namespace ddssec::rtps {

MessageSender::MessageSender(Transport& transport, const GuidPrefix& prefix)
    : transport_(transport), buffer_(kLargestMessage), out_(buffer_) {
  header_.prefix = prefix;
}

void MessageSender::protect_with(SendProtection& protection) {
  protection_ = &protection;
  for (auto* buffer : {&buffer_, &payload_, &plain_, &message_}) buffer->resize(kLargestProtected);
  out_ = SpanWriter(buffer_);
}

void MessageSender::begin(const Destination& to, bool wrapped) {
  const bool other = !std::ranges::equal(to.locators, to_.locators) || wrapped != wrapped_;
  if (out_.size() > 0 && (other || out_.size() >= kLargestMessage)) flush();
  const bool empty = out_.size() == 0;
  if (empty) write(out_, header_);
  // INFO_DST lasts until the next one or the end of the message.
  if ((empty && !to.prefix.is_zero()) || (!empty && to.prefix != to_.prefix))
    write(out_, InfoDestination{to.prefix});
  receiver_ = empty || to.prefix == receiver_ ? to.prefix : GuidPrefix{};
  to_ = to;
  wrapped_ = wrapped;
}

// DDS-Security 9.5.3.3.4.3: what is signed without its length ends in whole words.
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
    out_.take(*size);
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

void MessageSender::flush() {
  const bool any = out_.size() > kHeaderSize && !out_.overflowed();
  if (any && wrapped_) {
    const auto size = protection_->protect_message(receiver_, out_.view(), message_);
    if (size)
      transport_.send(BytesView(message_).first(*size), to_.locators);
    else
      protection_->on_unprotectable(size.error());
  } else if (any) {
    transport_.send(out_.view(), to_.locators);
  }
  out_.rewind(0);
  to_ = {};  // what it borrowed may end now
  flush_by_ = kNever;
}

}  // namespace ddssec::rtps
