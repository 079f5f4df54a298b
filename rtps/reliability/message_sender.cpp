#include "rtps/reliability/message_sender.hpp"

namespace ddssec::rtps {

MessageSender::MessageSender(Transport& transport, const GuidPrefix& prefix)
    : transport_(transport), out_(buffer_) {
  header_.prefix = prefix;
}

void MessageSender::begin(const Destination& to) {
  if (out_.size() > 0 && !std::ranges::equal(to.locators, to_.locators)) flush();
  const bool empty = out_.size() == 0;
  if (empty) write(out_, header_);
  // INFO_DST lasts until the next one or the end of the message.
  if ((empty && !to.prefix.is_zero()) || (!empty && to.prefix != to_.prefix))
    write(out_, InfoDestination{to.prefix});
  to_ = to;
}

void MessageSender::flush() {
  if (out_.size() > kHeaderSize && !out_.overflowed()) transport_.send(out_.view(), to_.locators);
  out_.rewind(0);
}

}  // namespace ddssec::rtps
