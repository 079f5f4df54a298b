// Roles ping and pong: round trips.
#include <algorithm>
#include <thread>

#include "programs/peer/session.hpp"

namespace ddssec::peer {
namespace {

constexpr std::uint32_t kWarmUp = 200;

double percentile(const std::vector<double>& sorted, double share) {
  const auto index = static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1));
  return sorted[index];
}

void say_round_trips(std::uint32_t size, std::vector<double>& microseconds) {
  std::ranges::sort(microseconds);
  say("rtt", {{"size", size},
              {"n", microseconds.size()},
              {"min_us", microseconds.front()},
              {"median_us", percentile(microseconds, 0.5)},
              {"p90_us", percentile(microseconds, 0.9)},
              {"p99_us", percentile(microseconds, 0.99)}});
}

/// Answers in the receiving thread: one wake-up less a round trip.
class Echo final : public rtps::DataReaderListener {
 public:
  explicit Echo(rtps::DataWriter<Blob>& writer) : writer_(writer) {}
  void on_data_available(rtps::AnyDataReader& reader) override {
    static_cast<rtps::DataReader<Blob>&>(reader).take(samples_);
    for (const auto& ping : samples_)
      if (ping.info.valid_data && writer_.write(ping.data)) ++answered_;
  }
  std::uint64_t answered() const { return answered_; }

 private:
  rtps::DataWriter<Blob>& writer_;
  rtps::Samples<Blob> samples_;
  std::atomic<std::uint64_t> answered_ = 0;
};

}  // namespace

int run_ping(Session& session) {
  const auto& options = session.options();
  const auto created = session.writer<Blob>("PerfPing", true);
  if (!created) return refused(created.error());
  const auto listening = session.reader<Blob>("PerfPong");
  if (!listening) return refused(listening.error());
  auto& writer = **created;
  auto& reader = **listening;
  const auto both = [&] {
    const auto current = std::min(matched(writer), matched(reader));
    session.note_matched("pong", current);
    return current > 0;
  };
  if (!session.wait_until(both)) return session.finish(kNeverMatched);
  Blob ping{0, 0, 0, Bytes(options.size, 0x5a)};
  std::vector<double> microseconds;
  rtps::Samples<Blob> pongs;
  for (std::uint32_t i = 0; i < kWarmUp + options.count && !session.over();) {
    ping.seq = i;
    ping.t_ns = static_cast<std::uint64_t>(session.nanoseconds());
    if (!writer.write(ping)) break;
    ++session.counts.written;
    while (reader.take(pongs, 1) == 0u && !session.over())
      reader.wait_for_unread(std::chrono::milliseconds(100));
    if (pongs.empty()) break;
    const auto& pong = pongs[0].data;
    ++session.counts.received;
    session.counts.corrupt += pong.seq != i || pong.data != ping.data;
    const auto taken = session.nanoseconds() - static_cast<std::int64_t>(ping.t_ns);
    if (i++ >= kWarmUp) microseconds.push_back(static_cast<double>(taken) / 1000);
  }
  if (!microseconds.empty()) say_round_trips(options.size, microseconds);
  if (session.counts.corrupt > 0) return session.finish(kSampleWrong);
  return session.finish(microseconds.size() < options.count ? kSamplesMissing : kDone);
}

int run_pong(Session& session) {
  const auto created = session.writer<Blob>("PerfPong", true);
  if (!created) return refused(created.error());
  Echo echo(**created);
  const auto listening = session.reader<Blob>("PerfPing", &echo);
  if (!listening) return refused(listening.error());
  auto& reader = **listening;
  while (!session.over()) {
    session.note_matched("ping", matched(reader));
    if (session.counts.ever_matched && matched(reader) == 0) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  reader.set_listener(nullptr);
  session.counts.received = session.counts.written = echo.answered();
  return session.finish(session.counts.ever_matched ? kDone : kNeverMatched);
}

}  // namespace ddssec::peer
