#include "plugins/cyclonedds/opened_message.hpp"

#include <algorithm>

namespace ddssec::cyclonedds {

OpenedMessage& OpenedMessage::of_this_thread() noexcept {
  static thread_local constinit OpenedMessage mine;
  return mine;
}

void OpenedMessage::remember(const MessageCall& call) noexcept {
  if (call.octets.size() < kHeadSize + kTailSize) return forget();
  plugin_ = call.plugin;
  receiver_ = call.receiver;
  sender_ = call.sender;
  address_ = call.octets.data();
  size_ = call.octets.size();
  std::ranges::copy(call.octets.first(kHeadSize), head_.begin());
  std::ranges::copy(call.octets.last(kTailSize), tail_.begin());
}

bool OpenedMessage::was_opened_for_another(const MessageCall& call) const noexcept {
  return plugin_ != nullptr && plugin_ == call.plugin && sender_ == call.sender &&
         receiver_ != call.receiver && address_ == call.octets.data() &&
         size_ == call.octets.size() && std::ranges::equal(call.octets.first(kHeadSize), head_) &&
         std::ranges::equal(call.octets.last(kTailSize), tail_);
}

}  // namespace ddssec::cyclonedds
