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

}  // namespace

int run_ping(Session& session) {
  const auto& options = session.options();
  auto& participant = session.participant();
  auto writer = rtps::DataWriter<Blob>::create(participant, "PerfPing", session.writer_qos(true));
  if (!writer) return refused(writer.error());
  auto reader = rtps::DataReader<Blob>::create(participant, "PerfPong", session.reader_qos());
  if (!reader) return refused(reader.error());
  const auto both = [&] {
    const auto current = std::min(writer->matched().current_count, reader->matched().current_count);
    session.note_matched("pong", current);
    return current > 0;
  };
  if (!session.wait_until(both)) return session.finish(kNeverMatched);
  Blob ping{0, 0, 0, Bytes(options.size, 0x5a)};
  std::vector<double> microseconds;
  for (std::uint32_t i = 0; i < kWarmUp + options.count && !session.over();) {
    ping.seq = i;
    ping.t_ns = static_cast<std::uint64_t>(session.nanoseconds());
    if (!writer->write(ping)) break;
    ++session.counts.written;
    std::optional<rtps::Sample<Blob>> pong;
    while (!session.over() && !(pong = reader->take()))
      reader->wait_for_data(std::chrono::milliseconds(100));
    if (!pong) break;
    ++session.counts.received;
    session.counts.corrupt += pong->data.seq != i || pong->data.data != ping.data;
    const auto taken = session.nanoseconds() - static_cast<std::int64_t>(ping.t_ns);
    if (i++ >= kWarmUp) microseconds.push_back(static_cast<double>(taken) / 1000);
  }
  if (!microseconds.empty()) say_round_trips(options.size, microseconds);
  if (session.counts.corrupt > 0) return session.finish(kSampleWrong);
  return session.finish(microseconds.size() < options.count ? kSamplesMissing : kDone);
}

int run_pong(Session& session) {
  auto& participant = session.participant();
  auto writer = rtps::DataWriter<Blob>::create(participant, "PerfPong", session.writer_qos(true));
  if (!writer) return refused(writer.error());
  auto reader = rtps::DataReader<Blob>::create(participant, "PerfPing", session.reader_qos());
  if (!reader) return refused(reader.error());
  std::atomic<std::uint64_t> answered = 0;
  // Answers in the receiving thread: one wake-up less a round trip.
  reader->on_data([&] {
    while (auto ping = reader->take())
      if (ping->info.valid_data && writer->write(ping->data)) ++answered;
  });
  while (!session.over()) {
    session.note_matched("ping", reader->matched().current_count);
    if (session.counts.ever_matched && reader->matched().current_count == 0) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  reader->on_data(nullptr);
  session.counts.received = session.counts.written = answered;
  return session.finish(session.counts.ever_matched ? kDone : kNeverMatched);
}

}  // namespace ddssec::peer
