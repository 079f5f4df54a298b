// Roles tput-pub and tput-sub: as many samples as the reader accepts.
#include "programs/peer/session.hpp"

namespace ddssec::peer {
namespace {

constexpr std::uint32_t kEndMarker = 0xffffffff;

}  // namespace

int run_tput_pub(Session& session) {
  const auto& options = session.options();
  const auto created = session.writer<Blob>("PerfTput", true);
  if (!created) return print_refusal(created.error());
  auto& writer = **created;
  const auto has_reader = [&] {
    const auto current = matched_count(writer);
    session.note_matched("reader", current);
    return current > 0;
  };
  if (!session.wait_until(has_reader)) return session.finish(kNeverMatched);
  Blob sample{0, 0, 0, Bytes(options.size, 0x5a)};
  const auto end = session.nanoseconds() + static_cast<std::int64_t>(options.duration * 1e9);
  while (session.nanoseconds() < end && !session.is_over()) {
    sample.t_ns = static_cast<std::uint64_t>(session.nanoseconds());
    if (!writer.write(sample)) continue;
    ++sample.seq;
    ++session.counts.written;
  }
  const Blob marker{kEndMarker, sample.seq, 0, {}};
  while (!session.is_over() && !writer.write(marker)) {
  }
  const bool complete = session.wait_until(
      [&] { return writer.wait_for_acknowledgments(std::chrono::milliseconds(10)).has_value(); });
  return session.finish(complete ? kDone : kSamplesMissing);
}

int run_tput_sub(Session& session) {
  const auto created = session.reader<Blob>("PerfTput");
  if (!created) return print_refusal(created.error());
  auto& reader = **created;
  rtps::Samples<Blob> samples;
  auto& counts = session.counts;
  std::int64_t first = 0, last = 0;
  std::uint64_t octets = 0;
  std::optional<std::uint32_t> sent;
  while (!session.is_over() && !sent) {
    reader.wait_for_unread(std::chrono::milliseconds(20));
    session.note_matched("writer", matched_count(reader));
    reader.take(samples);
    for (const auto& sample : samples) {
      if (!sample.info.valid_data) continue;
      if (sample.data.seq == kEndMarker) {
        sent = sample.data.pad;
        break;
      }
      counts.corrupt += sample.data.seq != counts.received ? 1 : 0;
      if (counts.received++ == 0) first = session.nanoseconds();
      octets += sample.data.data.size();
    }
    last = session.nanoseconds();
  }
  if (!counts.ever_matched) return session.finish(kNeverMatched);
  const auto seconds = std::max(1e-9, static_cast<double>(last - first) * 1e-9);
  print_line("tput", {{"size", session.options().size},
                      {"samples", counts.received},
                      {"sent", sent.value_or(0)},
                      {"seconds", seconds},
                      {"samples_per_s", static_cast<double>(counts.received) / seconds},
                      {"mbit_per_s", static_cast<double>(octets) * 8e-6 / seconds}});
  if (counts.corrupt > 0) return session.finish(kSampleWrong);
  return session.finish(sent && *sent == counts.received ? kDone : kSamplesMissing);
}

}  // namespace ddssec::peer
