// Roles pub and sub: coloured squares, each checked.
#include <thread>

#include "programs/peer/session.hpp"

namespace ddssec::peer {
namespace {

constexpr std::int32_t kShapeSize = 30;
constexpr auto kWritePeriod = std::chrono::milliseconds(20);

std::int32_t y_of(std::int32_t x) { return 3 * x + 7; }

bool is_right(const ShapeType& shape) {
  return shape.x >= 0 && shape.y == y_of(shape.x) && shape.shapesize == kShapeSize &&
         !shape.color.empty();
}

Json fields_of(const ShapeType& shape) {
  return {{"color", shape.color}, {"x", shape.x}, {"y", shape.y}, {"shapesize", shape.shapesize}};
}

}  // namespace

int run_pub(Session& session) {
  const auto& options = session.options();
  const auto created = session.writer<ShapeType>(session.topic_or("Square"), false);
  if (!created) return print_refusal(created.error());
  auto& writer = **created;
  auto& counts = session.counts;
  const auto has_reader = [&] {
    const auto current = matched_count(writer);
    session.note_matched("reader", current);
    return current > 0;
  };
  // The loop ends when all shapes are written and the reader has left.
  while (!session.is_over()) {
    const bool reader = has_reader();
    if (counts.written >= options.count && !reader) break;
    if (reader && counts.written < options.count) {
      const auto x = static_cast<std::int32_t>(counts.written);
      if (writer.write({options.color, x, y_of(x), kShapeSize})) ++counts.written;
    }
    std::this_thread::sleep_for(kWritePeriod);
  }
  if (!counts.ever_matched) return session.finish(kNeverMatched);
  return session.finish(counts.written < options.count ? kSamplesMissing : kDone);
}

int run_sub(Session& session) {
  const auto& options = session.options();
  const auto created = session.reader<ShapeType>(session.topic_or("Square"));
  if (!created) return print_refusal(created.error());
  auto& reader = **created;
  rtps::Samples<ShapeType> samples;
  auto& counts = session.counts;
  while (!session.is_over() && counts.received < options.count) {
    reader.wait_for_unread(std::chrono::milliseconds(20));
    session.note_matched("writer", matched_count(reader));
    reader.take(samples);
    for (const auto& sample : samples) {
      if (!sample.info.valid_data) continue;
      ++counts.received;
      counts.corrupt += is_right(sample.data) ? 0 : 1;
      if (counts.received == 1 || counts.received == options.count)
        print_line("sample", fields_of(sample.data));
    }
  }
  counts.corrupt += reader.malformed();
  if (counts.corrupt > 0) return session.finish(kSampleWrong);
  if (!counts.ever_matched) return session.finish(kNeverMatched);
  return session.finish(counts.received < options.count ? kSamplesMissing : kDone);
}

}  // namespace ddssec::peer
