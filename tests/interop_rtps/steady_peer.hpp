// A peer that writes at a steady rate, reads, and counts what arrives. There is one program for
// each stack. It reads commands from standard input, one on each line, and answers each with one
// line on standard output:
//   writer TOPIC KIND PERIOD_US SIZE     writes samples of SIZE octets, numbered from 0
//   reader TOPIC KIND [ECHO_TOPIC]       also writes each sample that arrives to ECHO_TOPIC, which
//                                        has a writer with period 0
//   report     gives the counts of each writer and reader, and the worst gap and latencies since
//              the last `phase`
//   phase      does the same, and begins to measure gaps and latencies again
//   stop       stops the writers
//   quit
// KIND: reliable (KEEP_ALL, VOLATILE), durable (reliable, TRANSIENT_LOCAL, the last kKept samples),
// best_effort.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <map>
#include <optional>
#include <poll.h>
#include <sstream>
#include <string>
#include <unistd.h>
#include <vector>

namespace steady {

/// Samples that a durable writer keeps: twenty seconds of a writer with a period of 20 ms.
inline constexpr int kKept = 1000;
inline constexpr int kBlockingMs = 10;
/// Samples that a best-effort reader keeps between two looks, which are a millisecond or more
/// apart.
inline constexpr int kBestEffortKept = 64;

struct Message {
  std::string writer;
  std::int32_t number = 0;
  std::vector<std::uint8_t> payload;  ///< begins with the time of sending
};

class Stack {
 public:
  virtual ~Stack() = default;
  /// The endpoints are numbered from 0, writers and readers separately. Both functions return false
  /// if the stack refuses.
  virtual bool add_writer(const std::string& topic, const std::string& kind) = 0;
  virtual bool add_reader(const std::string& topic, const std::string& kind) = 0;
  virtual bool write(std::size_t writer, const Message& message) = 0;
  virtual std::optional<Message> take(std::size_t reader) = 0;
  virtual int matched(bool is_writer, std::size_t endpoint) = 0;
  /// The samples without data that a reader has received: an instance was disposed, or has no
  /// writer any more.
  std::size_t ends(std::size_t reader) const {
    const auto found = ends_.find(reader);
    return found == ends_.end() ? 0 : found->second;
  }

 protected:
  void note_end(std::size_t reader) { ++ends_[reader]; }

 private:
  std::map<std::size_t, std::size_t> ends_;
};

inline std::int64_t now_ns() { return std::chrono::steady_clock::now().time_since_epoch().count(); }

/// What one reader received from one writer.
class Stream {
 public:
  void add(const Message& message) {
    const auto now = now_ns();
    const auto number = static_cast<std::size_t>(message.number);
    first_ = seen_.empty() ? number : std::min(first_, number);
    if (number >= seen_.size()) seen_.resize(number + 1);
    ++received_;
    repeated_ += seen_[number];
    distinct_ += !seen_[number];
    if (last_ns_ > 0 && now - last_ns_ > worst_gap_ns_) {
      worst_gap_ns_ = now - last_ns_;
      worst_gap_at_ns_ = now;
    }
    last_ns_ = last_arrival_ns_ = now;
    std::int64_t sent = 0;
    std::memcpy(&sent, message.payload.data(), sizeof sent);
    // A repeated sample is late because its reader did not exist at the time.
    if (!seen_[number]) latencies_.push_back(now - sent);
    seen_[number] = true;
  }
  std::string report() {
    // Not sorted: with 600,000 latencies, that would stop this peer's writers for some 80 ms.
    const auto at = [&](std::size_t percent) {
      if (latencies_.empty()) return 0.0;
      const auto place =
          latencies_.begin() + static_cast<std::ptrdiff_t>((latencies_.size() - 1) * percent / 100);
      std::nth_element(latencies_.begin(), place, latencies_.end());
      return static_cast<double>(*place) / 1e6;
    };
    std::ostringstream out;
    out << "\"received\": " << received_ << ", \"repeated\": " << repeated_
        << ", \"first\": " << first_ << ", \"highest\": " << seen_.size() - 1
        << ", \"missing\": " << seen_.size() - first_ - distinct_
        << ", \"samples\": " << latencies_.size() << ", \"p50_ms\": " << at(50)
        << ", \"p99_ms\": " << at(99) << ", \"worst_gap_ms\": "
        << static_cast<double>(std::max(worst_gap_ns_, now_ns() - last_ns_)) / 1e6
        << ", \"worst_gap_at_s\": " << std::to_string(static_cast<double>(worst_gap_at_ns_) / 1e9)
        << ", \"last_s\": " << std::to_string(static_cast<double>(last_arrival_ns_) / 1e9);
    return out.str();
  }
  void begin_phase() {
    latencies_.clear();
    worst_gap_ns_ = worst_gap_at_ns_ = 0;
    last_ns_ = now_ns();
  }

 private:
  std::vector<bool> seen_;
  std::vector<std::int64_t> latencies_;
  std::size_t first_ = 0, received_ = 0, repeated_ = 0, distinct_ = 0;
  std::int64_t worst_gap_ns_ = 0, worst_gap_at_ns_ = 0, last_ns_ = 0, last_arrival_ns_ = 0;
};

struct Writer {
  std::string topic;
  std::int64_t period_ns = 0;
  Message next;
  std::int64_t due_ns = 0;
  std::size_t refused = 0;
};

struct Reader {
  std::string topic;
  std::optional<std::size_t> echo;
  std::map<std::string, Stream> streams;
};

class Peer {
 public:
  Peer(Stack& stack, std::string name) : stack_(stack), name_(std::move(name)) {}

  int serve() {
    say("{\"ready\": true}");
    while (!is_over_) {
      read_commands();
      if (!is_stopped_)
        for (std::size_t i = 0; i < writers_.size(); ++i) write_due(i);
      for (std::size_t i = 0; i < readers_.size(); ++i) take_all(i);
    }
    return 0;
  }

 private:
  static void say(const std::string& line) {
    std::printf("%s\n", line.c_str()), std::fflush(stdout);
  }

  // Reads commands, and waits for at most a millisecond.
  void read_commands() {
    pollfd in{STDIN_FILENO, POLLIN, 0};
    if (::poll(&in, 1, 1) <= 0) return;
    char octets[4096];
    const auto count = ::read(STDIN_FILENO, octets, sizeof octets);
    if (count <= 0) is_over_ = true;
    input_.append(octets, static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    for (auto end = input_.find('\n'); end != std::string::npos; end = input_.find('\n')) {
      say(answer(input_.substr(0, end)));
      input_.erase(0, end + 1);
    }
  }

  std::string answer(const std::string& text) {
    std::istringstream line(text);
    std::string command;
    line >> command;
    if (command == "writer") return add_writer(line);
    if (command == "reader") return add_reader(line);
    if (command == "stop") is_stopped_ = true;
    if (command == "quit") is_over_ = true;
    if (command != "report" && command != "phase") return "{\"ok\": true}";
    const auto out = report();
    if (command == "phase")
      for (auto& reader : readers_)
        for (auto& [_, stream] : reader.streams) stream.begin_phase();
    return out;
  }

  std::string add_writer(std::istringstream& line) {
    Writer writer;
    std::string kind;
    std::size_t size = 0;
    line >> writer.topic >> kind >> writer.period_ns >> size;
    writer.period_ns *= 1000;
    writer.due_ns = now_ns();
    writer.next = {name_, 0, std::vector<std::uint8_t>(std::max(size, sizeof(std::int64_t)))};
    if (!stack_.add_writer(writer.topic, kind)) return "{\"ok\": false}";
    writers_.push_back(std::move(writer));
    return "{\"ok\": true}";
  }

  std::string add_reader(std::istringstream& line) {
    Reader reader;
    std::string kind, echo;
    line >> reader.topic >> kind >> echo;
    for (std::size_t i = 0; i < writers_.size(); ++i)
      if (writers_[i].topic == echo) reader.echo = i;
    if (!stack_.add_reader(reader.topic, kind)) return "{\"ok\": false}";
    readers_.push_back(std::move(reader));
    return "{\"ok\": true}";
  }

  // Writes what is due. A writer that was delayed writes only so many samples at once, and a
  // refused sample is written again.
  void write_due(std::size_t index) {
    auto& writer = writers_[index];
    const auto now = now_ns();
    for (int i = 0; i < 50 && writer.period_ns > 0 && writer.due_ns <= now; ++i) {
      std::memcpy(writer.next.payload.data(), &now, sizeof now);
      if (!stack_.write(index, writer.next)) return void(++writer.refused);
      ++writer.next.number;
      writer.due_ns += writer.period_ns;
    }
  }

  void take_all(std::size_t index) {
    auto& reader = readers_[index];
    while (const auto message = stack_.take(index)) {
      reader.streams[message->writer].add(*message);
      if (!reader.echo || is_stopped_) continue;
      auto& writer = writers_[*reader.echo];
      writer.next.payload = message->payload;
      if (stack_.write(*reader.echo, writer.next)) ++writer.next.number;
    }
  }

  std::string report() {
    std::ostringstream out;
    out << "{\"writers\": [";
    for (std::size_t i = 0; i < writers_.size(); ++i)
      out << (i == 0 ? "" : ", ") << "{\"topic\": \"" << writers_[i].topic
          << "\", \"written\": " << writers_[i].next.number
          << ", \"refused\": " << writers_[i].refused
          << ", \"matched\": " << stack_.matched(true, i) << "}";
    out << "], \"readers\": [";
    for (std::size_t i = 0; i < readers_.size(); ++i) {
      out << (i == 0 ? "" : ", ") << "{\"topic\": \"" << readers_[i].topic
          << "\", \"matched\": " << stack_.matched(false, i) << ", \"ends\": " << stack_.ends(i)
          << ", \"streams\": {";
      bool is_first = true;
      for (auto& [writer, stream] : readers_[i].streams) {
        out << (is_first ? "" : ", ") << "\"" << writer << "\": {" << stream.report() << "}";
        is_first = false;
      }
      out << "}}";
    }
    out << "]}";
    return out.str();
  }

  Stack& stack_;
  const std::string name_;
  std::vector<Writer> writers_;
  std::vector<Reader> readers_;
  std::string input_;
  bool is_over_ = false, is_stopped_ = false;
};

}  // namespace steady
