#include "rtps/reliability/local_delivery.hpp"

#include "rtps/reliability/stateful_reader.hpp"

namespace ddssec::rtps {

void LocalDelivery::offer(ReaderProxy& proxy) {
  auto number = history_.next_held(proxy.acknowledged().next());
  for (; number <= history_.last(); number = history_.next_held(number.next()))
    if (!proxy.ends_before(number) && !proxy.local->offer(*history_.find(number))) break;
  readers_.acknowledge(proxy, number.previous());
  proxy.local->skip(writer_, number);
  if (group_ != nullptr && number > history_.last()) proxy.local->pass(writer_, group_->current);
}

void LocalDelivery::offer_to_all() {
  for (auto& [guid, proxy] : readers_.all())
    if (proxy.local != nullptr) offer(proxy);
}

void LocalDelivery::assert_liveliness() {
  for (auto& [guid, proxy] : readers_.all())
    if (proxy.local != nullptr) proxy.local->hear(writer_);
}

void LocalDelivery::detach_all() {
  for (auto& [guid, proxy] : readers_.all())
    if (proxy.local != nullptr) proxy.local->detach(writer_);
}

}  // namespace ddssec::rtps
