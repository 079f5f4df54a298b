#include "rtps/reliability/retransmissions.hpp"

#include <algorithm>

namespace ddssec::rtps {

bool Retransmissions::answer(ReaderProxy& proxy, const Receiver& receiver,
                             const SequenceNumberSet& missing, MonotonicTime now) {
  if (proxy.was_just_answered(missing.base(), now)) return false;
  const auto lowest = lowest_for(proxy);
  std::size_t octets = 0;
  const auto most = std::min(proxy.allowance.renewed(now), kMaxOctetsPerAnswer);
  bool gap_below_sent = false;
  missing.for_each([&](SequenceNumber number) {
    if (number > history_.last() || !is_valid(number) || octets >= most) return;
    if (number < lowest) {
      if (!gap_below_sent) messages_.gap(receiver, number, lowest);
      gap_below_sent = true;
    } else if (const auto* change = history_.find(number); change && proxy.accepts(*change)) {
      messages_.change(receiver, *change, {}, FragmentRepair::kFragmentsPerPortion);
      octets += std::max(change->payload.size(), kMinOctets);
    } else {
      messages_.gap(receiver, number, number.next());
    }
  });
  proxy.allowance.spend(octets);
  return true;
}

bool Retransmissions::begin(ReaderProxy& proxy, const NackFrag& nack, MonotonicTime now) {
  if (proxy.repair.is_crossed_by(nack, now) || proxy.allowance.renewed(now) == 0) return false;
  proxy.repair.begin(nack, now);
  return true;
}

bool Retransmissions::send_portion(ReaderProxy& proxy, const Receiver& receiver,
                                   MonotonicTime now) {
  auto& repair = proxy.repair;
  const auto sample = repair.sample();
  const auto* change = proxy.acknowledged() < sample ? history_.find(sample) : nullptr;
  if (change != nullptr && proxy.accepts(*change)) {
    repair.send_portion(now, [&](FragmentNumber number) {
      messages_.fragment(receiver, *change, number);
      proxy.allowance.spend(messages_.fragment_size());
    });
    return true;
  }
  repair.end();
  if (proxy.acknowledged() < sample) messages_.gap(receiver, sample, sample.next());
  return false;
}

}  // namespace ddssec::rtps
