#include "rtps/reliability/retransmissions.hpp"

#include <algorithm>

namespace ddssec::rtps {

// The answer to one request. The numbers are passed to it in ascending order.
class Retransmissions::Answer {
 public:
  Answer(Retransmissions& from, ReaderProxy& proxy, const Receiver& receiver, MonotonicTime now)
      : from_(from),
        proxy_(proxy),
        receiver_(receiver),
        now_(now),
        lowest_(from.lowest_for(proxy)),
        left_(std::min(proxy.allowance.renewed(now), kMaxOctetsPerAnswer)),
        evaluations_(from.evaluations_.renewed(now)) {}

  void add(SequenceNumber number) {
    if (left_ == 0 || number > from_.history_.last() || !is_valid(number) || number < gap_end_)
      return;
    if (number < lowest_) return skip(number, lowest_);
    const auto* change = from_.history_.find(number);
    if (change == nullptr) return skip(number, from_.history_.next_held(number));
    if (const auto end = proxy_.rejected_until(number)) return skip(number, *end);
    const auto passes = judge(*change);
    if (!passes) {
      left_ = 0;  // the reader requests the rest again
    } else if (!*passes) {
      skip(number, number.next());
    } else {
      end_gap();
      from_.messages_.change(receiver_, *change, {}, FragmentRepair::kFragmentsPerPortion);
      spend(std::max(change->payload.size(), kMinOctets));
    }
  }
  // Sends the open gap, if there is one. Must also be called after the last number.
  void end_gap() {
    if (gap_begin_ == gap_end_) return;
    from_.messages_.gap(receiver_, gap_begin_, gap_end_);
    gap_begin_ = gap_end_;
    spend(kMinOctets);
  }

 private:
  // Whether the reader gets the change. Empty if no evaluation is allowed now.
  std::optional<bool> judge(const Change& change) {
    if (!proxy_.is_for(change)) return false;
    if (!proxy_.is_evaluated_again(change)) return true;
    const auto price = evaluation_price(change.payload.size());
    if (price > evaluations_)
      return proxy_.try_skip_evaluation(now_) ? std::optional(true) : std::nullopt;
    proxy_.end_wait_for_evaluation();
    evaluations_ -= price;
    from_.evaluations_.spend(price);
    return proxy_.evaluate(change);
  }
  void skip(SequenceNumber first, SequenceNumber end) {
    if (first != gap_end_) {
      end_gap();
      gap_begin_ = first;
    }
    gap_end_ = end;
  }
  void spend(std::size_t octets) {
    proxy_.allowance.spend(octets);
    left_ -= std::min(left_, octets);
  }

  Retransmissions& from_;
  ReaderProxy& proxy_;
  const Receiver& receiver_;
  const MonotonicTime now_;
  const SequenceNumber lowest_;
  std::size_t left_;                          // octets that may still be sent
  std::size_t evaluations_;                   // what evaluations of filters may still cost
  SequenceNumber gap_begin_{1}, gap_end_{1};  // the open gap; empty if they are equal
};

bool Retransmissions::answer(ReaderProxy& proxy, const Receiver& receiver,
                             const SequenceNumberSet& missing, MonotonicTime now) {
  if (proxy.was_just_answered(missing.base(), now)) return false;
  Answer answer(*this, proxy, receiver, now);
  missing.for_each([&](SequenceNumber number) { answer.add(number); });
  answer.end_gap();
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
  // What was acknowledged may be requested again: an attacker can forge an ACKNACK. The reader's
  // filter is not evaluated, because this is done for each portion. A reader that requests
  // fragments has a part of the sample, so the sample passed, or was too large for an evaluation.
  const auto* change = lowest_for(proxy) <= sample ? history_.find(sample) : nullptr;
  const bool is_wanted =
      change != nullptr && proxy.is_for(*change) && !proxy.rejected_until(sample);
  if (is_wanted) {
    repair.send_portion(now, [&](FragmentNumber number) {
      messages_.fragment(receiver, *change, number);
      proxy.allowance.spend(messages_.fragment_size());
    });
    return true;
  }
  repair.end();
  const bool was_written = sample <= history_.last();
  if (was_written && proxy.acknowledged() < sample) messages_.gap(receiver, sample, sample.next());
  return false;
}

}  // namespace ddssec::rtps
