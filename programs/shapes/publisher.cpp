// Option -P: shapes that bounce within their area.
#include "programs/shapes/session.hpp"

namespace ddssec::shapes {
namespace {

constexpr std::int32_t kWidth = 240, kHeight = 270;
constexpr auto kMaxAcknowledgmentWait = std::chrono::seconds(1);

std::int32_t below(Random& random, std::int32_t end) {
  std::array<std::uint8_t, 2> octets{};
  if (!random.fill(octets)) return 0;
  return (octets[0] << 8 | octets[1]) % end;
}

// One coordinate of a shape. It moves, and turns at 0 and at `limit`.
class Coordinate {
 public:
  Coordinate(Random& random, std::int32_t limit)
      : at_(below(random, limit)),
        speed_((below(random, 5) + 1) * (below(random, 2) == 0 ? 1 : -1)),
        max_(limit) {}

  std::int32_t move() {
    at_ += speed_;
    if (at_ < 0 || at_ > max_) {
      at_ = at_ < 0 ? 0 : max_;
      speed_ = -speed_;
    }
    return at_;
  }

 private:
  std::int32_t at_, speed_, max_;
};

template <class T>
class PublisherRun {
 public:
  explicit PublisherRun(Session& session)
      : session_(session),
        options_(session.options()),
        x_(session.random(), kWidth),
        y_(session.random(), kHeight) {
    if constexpr (requires { shape_.additional_payload_size; }) {
      shape_.additional_payload_size.resize(options_.payload_size);
      if (options_.payload_size > 0) shape_.additional_payload_size.back() = 255;
    }
    shape_.shapesize = options_.size;
  }

  int run() {
    const auto topics = session_.create_topics<T>();
    if (!topics) return not_created("topic", topics.error());
    auto& publisher = session_.participant().create_publisher(session_.group_qos());
    for (auto* topic : *topics) {
      print_line("Create writer for topic: %s color: %s", topic->name().c_str(),
                 options_.color.c_str());
      auto writer = publisher.template create_datawriter<T>(*topic, session_.writer_qos());
      if (!writer) return not_created("datawriter", writer.error());
      writers_.push_back(*writer);
    }
    const auto code = write(publisher);
    for (auto* writer : writers_) finish(*writer);
    return code;
  }

 private:
  int write(rtps::Publisher& publisher) {
    const auto& presentation = options_.presentation;
    const auto count = presentation.coherent_access ? options_.coherent_samples : 0;
    for (std::uint64_t n = 0; options_.iterations == 0 || n < options_.iterations; ++n) {
      next_shape();
      if (count != 0 && n % count == 0 && !publisher.begin_coherent_changes()) return kRunFailed;
      for (auto* writer : writers_)
        if (!write_instances(*writer)) return kRunFailed;
      if (count != 0 && n % count == count - 1 && !publisher.end_coherent_changes())
        return kRunFailed;
      if (!session_.pause(options_.write_period)) break;
    }
    return kDone;
  }

  bool write_instances(rtps::DataWriter<T>& writer) {
    Status outcome;
    each_instance([&] {
      const auto written = writer.write(shape_);
      if (written && options_.print_written) print_sample(writer.topic().name(), shape_);
      // With KEEP_ALL a slow reader may block the writer. Then this shape is skipped.
      if (!written && written.error().code() != Code::rtps_history_full) outcome = written;
    });
    if (outcome) return true;
    print_line("failed to write");
    std::fprintf(stderr, "ddssec-shapes: %s\n", outcome.error().to_sentence().c_str());
    return false;
  }

  // Sends what readers should still receive before the writer is deleted.
  void finish(rtps::DataWriter<T>& writer) {
    each_instance([&] {
      if (options_.final_state == FinalState::disposed)
        static_cast<void>(writer.dispose(shape_));
      else if (options_.final_state == FinalState::unregistered)
        static_cast<void>(writer.unregister_instance(shape_));
    });
    if (options_.reliable)
      static_cast<void>(writer.wait_for_acknowledgments(kMaxAcknowledgmentWait));
  }

  void next_shape() {
    shape_.x = x_.move();
    shape_.y = y_.move();
    if (options_.size != 0) return;
    if (options_.size_modulo > 0) shape_.shapesize %= options_.size_modulo;
    ++shape_.shapesize;
  }

  template <class F>
  void each_instance(F&& f) {
    for (std::uint32_t i = 0; i < options_.instances; ++i) {
      shape_.color = Options::numbered(options_.color, i);
      f();
    }
  }

  Session& session_;
  const Options& options_;
  Coordinate x_, y_;
  T shape_;
  std::vector<rtps::DataWriter<T>*> writers_;
};

}  // namespace

template <class T>
int run_publisher(Session& session) {
  return PublisherRun<T>(session).run();
}
template int run_publisher<ShapeType>(Session&);
template int run_publisher<FinalShapeType>(Session&);

}  // namespace ddssec::shapes
