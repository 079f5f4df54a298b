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
  print_line("rtt", {{"size", size},
                     {"n", microseconds.size()},
                     {"min_us", microseconds.front()},
                     {"median_us", percentile(microseconds, 0.5)},
                     {"p90_us", percentile(microseconds, 0.9)},
                     {"p99_us", percentile(microseconds, 0.99)}});
}

// Answers in the receiving thread, which saves one wake-up for each round trip. Pings that arrive
// before a thread reads the answers wait in the reader.
class Echo final : public rtps::DataReaderListener, public rtps::DataWriterListener {
 public:
  explicit Echo(rtps::DataWriter<Blob>& writer) : writer_(writer) {
    writer.set_listener(this);
    is_heard_ = matched_count(writer) > 0;
  }
  void on_data_available(rtps::AnyDataReader& reader) override {
    reader_ = static_cast<rtps::DataReader<Blob>*>(&reader);
    answer();
  }
  void on_publication_matched(rtps::AnyDataWriter&, const rtps::MatchedStatus& status) override {
    is_heard_ = status.current_count > 0;
    answer();
  }
  std::uint64_t answered() const { return answered_; }

 private:
  void answer() {
    if (!is_heard_ || reader_ == nullptr) return;
    reader_->take(samples_);
    for (const auto& ping : samples_)
      if (ping.info.valid_data && writer_.write(ping.data)) ++answered_;
  }

  rtps::DataWriter<Blob>& writer_;
  rtps::DataReader<Blob>* reader_ = nullptr;
  std::atomic<bool> is_heard_ = false;
  rtps::Samples<Blob> samples_;
  std::atomic<std::uint64_t> answered_ = 0;
};

// Sends a ping until its pong arrives: the answering side may not have matched yet, and then does
// not receive it.
class Ping {
 public:
  Ping(Session& session, rtps::DataWriter<Blob>& writer, rtps::DataReader<Blob>& reader)
      : session_(session),
        writer_(writer),
        reader_(reader),
        sent_{0, 0, 0, Bytes(session.options().size, 0x5a)} {}

  // Returns the time of a round trip in nanoseconds. Empty if the session ended before.
  std::optional<std::int64_t> round_trip() {
    const auto begin = session_.nanoseconds();
    sent_.t_ns = static_cast<std::uint64_t>(begin);
    while (!session_.is_over()) {
      if (!writer_.write(sent_)) return std::nullopt;
      if (await_pong()) {
        ++session_.counts.written;
        ++sent_.seq;
        return session_.nanoseconds() - begin;
      }
    }
    return std::nullopt;
  }

 private:
  // If a ping was sent twice, its second pong arrives while another is awaited.
  bool await_pong() {
    constexpr std::int64_t kAgain = 200'000'000;
    for (const auto end = session_.nanoseconds() + kAgain;
         session_.nanoseconds() < end && !session_.is_over();) {
      if (reader_.take(pongs_, 1) == 0u) {
        reader_.wait_for_unread(std::chrono::milliseconds(100));
        continue;
      }
      const auto& pong = pongs_[0].data;
      if (pong.seq < sent_.seq) continue;
      ++session_.counts.received;
      session_.counts.corrupt += pong.seq != sent_.seq || pong.data != sent_.data;
      return true;
    }
    return false;
  }

  Session& session_;
  rtps::DataWriter<Blob>& writer_;
  rtps::DataReader<Blob>& reader_;
  Blob sent_;
  rtps::Samples<Blob> pongs_;
};

}  // namespace

int run_ping(Session& session) {
  const auto& options = session.options();
  const auto created = session.writer<Blob>("PerfPing", true);
  if (!created) return print_refusal(created.error());
  const auto listening = session.reader<Blob>("PerfPong");
  if (!listening) return print_refusal(listening.error());
  auto& writer = **created;
  auto& reader = **listening;
  const auto both = [&] {
    const auto current = std::min(matched_count(writer), matched_count(reader));
    session.note_matched("pong", current);
    return current > 0;
  };
  if (!session.wait_until(both)) return session.finish(kNeverMatched);
  Ping ping(session, writer, reader);
  std::vector<double> microseconds;
  for (std::uint32_t i = 0; i < kWarmUp + options.count; ++i) {
    const auto taken = ping.round_trip();
    if (!taken) break;
    if (i >= kWarmUp) microseconds.push_back(static_cast<double>(*taken) / 1000);
  }
  if (!microseconds.empty()) say_round_trips(options.size, microseconds);
  if (session.counts.corrupt > 0) return session.finish(kSampleWrong);
  return session.finish(microseconds.size() < options.count ? kSamplesMissing : kDone);
}

int run_pong(Session& session) {
  const auto created = session.writer<Blob>("PerfPong", true);
  if (!created) return print_refusal(created.error());
  Echo echo(**created);
  const auto listening = session.reader<Blob>("PerfPing", &echo);
  if (!listening) {
    (*created)->set_listener(nullptr);
    return print_refusal(listening.error());
  }
  auto& reader = **listening;
  while (!session.is_over()) {
    const auto status = reader.subscription_matched_status();
    session.note_matched("ping", status.current_count);
    // A ping may have arrived, received its answers and left since the last check.
    session.counts.ever_matched = session.counts.ever_matched || status.total_count > 0;
    if (session.counts.ever_matched && status.current_count == 0) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  reader.set_listener(nullptr);
  (*created)->set_listener(nullptr);
  session.counts.received = session.counts.written = echo.answered();
  return session.finish(session.counts.ever_matched ? kDone : kNeverMatched);
}

}  // namespace ddssec::peer
