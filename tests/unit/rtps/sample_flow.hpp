// Samples from a writer over the wire to a reader's take, with their allocations counted. The test
// serves both participants (own_thread = false). Its clock stands still between two of their
// announcements, because these do allocate.
#pragma once

#include <unistd.h>

#include <gtest/gtest.h>

#include "rtps/dcps/domain_participant.hpp"
#include "tests/support/counted_memory.hpp"

namespace ddssec::rtps {

struct Keyed {
  std::string name;
  std::uint32_t number = 0;
  std::vector<std::uint8_t> octets = {};
};
template <>
struct TypeTraits<Keyed> {
  static constexpr std::string_view type_name = "Keyed";
  static constexpr auto extensibility = Extensibility::final_type;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(key(s.name, 40), s.number, s.octets);
  }
};
struct Plain {
  std::string name;
  std::uint32_t number = 0;
  std::vector<std::uint8_t> octets = {};
};
template <>
struct TypeTraits<Plain> {
  static constexpr std::string_view type_name = "Plain";
  static constexpr auto extensibility = Extensibility::final_type;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(s.name, s.number, s.octets);
  }
};

namespace testing {

/// Returns options for a loopback address that only this process uses, because announcements of
/// others would be counted, too.
inline DomainParticipantOptions undisturbed() {
  const auto octet = [](int shift) { return std::to_string(::getpid() >> shift & 0xff); };
  const auto address = "127.72." + octet(8) + "." + octet(0);
  return {.domain_id = 72,
          .interfaces = {address},
          .multicast = false,
          .peers = {address},
          .own_thread = false,
          .delivers_in_process = false};
}

struct Flow {
  HistoryKind history = HistoryKind::keep_all;
  std::size_t size = 0;
  int samples = 0;
};

template <DdsType T>
class SampleFlow {
 public:
  SampleFlow(ManualClock& clock, DomainParticipant& from, DomainParticipant& to, const Flow& flow)
      : clock_(clock),
        from_(from),
        to_(to),
        flow_(flow),
        sent_{"one of the instances", 0, Bytes(flow.size, 7)} {
    auto qos = default_writer_qos();
    qos.history.kind = flow.history;
    writer_ = *from.create_publisher().create_datawriter<T>(**from.create_topic<T>("T"), qos);
    reader_ = *to.create_subscriber().create_datareader<T>(**to.create_topic<T>("T"), qos);
  }

  /// Returns the allocations of all samples, once a tenth of them has flowed.
  std::int64_t allocations() {
    const auto matched = [&] {
      return !writer_->matched_subscriptions().empty() && !reader_->matched_publications().empty();
    };
    for (int i = 0; i < 250 || (i < 2000 && !matched()); ++i) poll(std::chrono::milliseconds(10));
    EXPECT_TRUE(matched());
    send(flow_.samples / 10);
    return counted_memory::allocations_of([&] { send(flow_.samples); });
  }

 private:
  void poll(std::chrono::nanoseconds later) {
    clock_.advance(later);
    from_.poll({});
    to_.poll({});
  }
  void send(int samples) {
    for (int i = 0; i < samples; ++i) {
      ++sent_.number;
      if (!writer_->write(sent_)) return fail(i);
      for (int tries = 0; reader_->take(received_) == 0u; ++tries) {
        if (tries == 5000) return fail(i);
        poll(std::chrono::microseconds(tries < 100 ? 1 : 1000));
      }
      if (received_.size() != 1 || received_[0].data.number != sent_.number ||
          received_[0].data.octets != sent_.octets)
        return fail(i);
    }
  }
  static void fail(int i) { ADD_FAILURE() << "sample " << i << " did not come as it was sent"; }

  ManualClock& clock_;
  DomainParticipant &from_, &to_;
  const Flow flow_;
  T sent_;
  Samples<T> received_;
  DataWriter<T>* writer_;
  DataReader<T>* reader_;
};

}  // namespace testing
}  // namespace ddssec::rtps
