// The steady peer on the embedded participant: NAME DOMAIN FOLDER.
#include "interop_rtps/steady_peer.hpp"
#include "secured/participant.hpp"
#include "shape.hpp"

namespace ddssec {
namespace {

class Embedded final : public steady::Stack {
 public:
  explicit Embedded(secured::Participant& participant) : participant_(participant) {}

  bool add_writer(const std::string& topic, const std::string& kind) override {
    auto qos = qos_of(secured::Participant::writer_qos(), kind);
    qos.reliability.max_blocking_time =
        rtps::Duration::from(std::chrono::milliseconds(steady::kBlockingMs));
    // A durable embedded writer that keeps all samples keeps them for late joiners, so it gets a
    // depth.
    if (kind == "durable") qos.history = {rtps::HistoryKind::keep_last, steady::kKept};
    const auto made = participant_.create_writer<interop::Shape>(topic, qos);
    if (made) writers_.push_back(*made);
    return made.has_value();
  }
  bool add_reader(const std::string& topic, const std::string& kind) override {
    const auto made = participant_.create_reader<interop::Shape>(
        topic, qos_of(secured::Participant::reader_qos(), kind));
    if (made) readers_.push_back(*made);
    return made.has_value();
  }
  bool write(std::size_t writer, const steady::Message& message) override {
    return writers_[writer]
        ->write({message.writer, message.number, 0, 0, message.payload})
        .has_value();
  }
  std::optional<steady::Message> take(std::size_t reader) override {
    auto taken = readers_[reader]->take_next_sample();
    while (taken && !taken->info.valid_data) {
      note_end(reader);
      taken = readers_[reader]->take_next_sample();
    }
    if (!taken) return std::nullopt;
    return steady::Message{taken->data.color, taken->data.x, std::move(taken->data.payload)};
  }
  int matched(bool is_writer, std::size_t endpoint) override {
    return is_writer ? writers_[endpoint]->publication_matched_status().current_count
                     : readers_[endpoint]->subscription_matched_status().current_count;
  }

 private:
  static rtps::Qos qos_of(rtps::Qos qos, const std::string& kind) {
    qos.reliability.kind = kind == "best_effort" ? rtps::ReliabilityKind::best_effort
                                                 : rtps::ReliabilityKind::reliable;
    if (kind == "durable") qos.durability = rtps::DurabilityKind::transient_local;
    qos.history = kind == "best_effort"
                      ? rtps::History{rtps::HistoryKind::keep_last, steady::kBestEffortKept}
                      : rtps::History{rtps::HistoryKind::keep_all};
    return qos;
  }

  secured::Participant& participant_;
  std::vector<rtps::DataWriter<interop::Shape>*> writers_;
  std::vector<rtps::DataReader<interop::Shape>*> readers_;
};

}  // namespace
}  // namespace ddssec

int main(int argc, char** argv) {
  using ddssec::secured::or_exit;
  using ddssec::secured::Participant;
  if (argc != 4) return 2;
  auto participant = or_exit(Participant::join(argv[3], {.domain_id = std::atoi(argv[2])}));
  ddssec::Embedded stack(participant);
  return steady::Peer(stack, argv[1]).serve();
}
