// The steady peer on Cyclone DDS, whose documents CYCLONEDDS_URI names: NAME DOMAIN.
#include <dds/dds.h>

#include "interop_rtps/steady_peer.hpp"
#include "shape.h"

namespace {

class Cyclone final : public steady::Stack {
 public:
  explicit Cyclone(dds_entity_t participant) : participant_(participant) {}

  bool add_writer(const std::string& topic, const std::string& kind) override {
    return add(writers_, topic, kind, dds_create_writer);
  }
  bool add_reader(const std::string& topic, const std::string& kind) override {
    return add(readers_, topic, kind, dds_create_reader);
  }
  bool write(std::size_t writer, const steady::Message& message) override {
    interop_Shape shape{};
    shape.color = const_cast<char*>(message.writer.c_str());
    shape.x = message.number;
    shape.payload._length = shape.payload._maximum =
        static_cast<std::uint32_t>(message.payload.size());
    shape.payload._buffer = const_cast<std::uint8_t*>(message.payload.data());
    return dds_write(writers_[writer], &shape) == DDS_RETCODE_OK;
  }
  std::optional<steady::Message> take(std::size_t reader) override {
    void* raw = nullptr;
    dds_sample_info_t info;
    std::optional<steady::Message> out;
    while (!out && dds_take(readers_[reader], &raw, &info, 1, 1) == 1) {
      const auto& shape = *static_cast<const interop_Shape*>(raw);
      if (!info.valid_data)
        note_end(reader);
      else
        out = {shape.color,
               shape.x,
               {shape.payload._buffer, shape.payload._buffer + shape.payload._length}};
      dds_return_loan(readers_[reader], &raw, 1);
      raw = nullptr;
    }
    return out;
  }
  int matched(bool is_writer, std::size_t endpoint) override {
    dds_publication_matched_status_t publication{};
    dds_subscription_matched_status_t subscription{};
    if (is_writer)
      dds_get_publication_matched_status(writers_[endpoint], &publication);
    else
      dds_get_subscription_matched_status(readers_[endpoint], &subscription);
    return static_cast<int>(publication.current_count + subscription.current_count);
  }

 private:
  template <class Create>
  bool add(std::vector<dds_entity_t>& out, const std::string& topic, const std::string& kind,
           Create create) {
    auto* qos = dds_create_qos();
    if (kind == "best_effort") {
      dds_qset_reliability(qos, DDS_RELIABILITY_BEST_EFFORT, 0);
      dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, steady::kBestEffortKept);
    } else {
      dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(steady::kBlockingMs));
      dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
    }
    if (kind == "durable") {
      dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
      dds_qset_durability_service(qos, 0, DDS_HISTORY_KEEP_LAST, steady::kKept, -1, -1, -1);
    }
    const auto on =
        dds_create_topic(participant_, &interop_Shape_desc, topic.c_str(), nullptr, nullptr);
    const auto made = on < 0 ? on : create(participant_, on, qos, nullptr);
    dds_delete_qos(qos);
    if (made < 0) std::fprintf(stderr, "%s: %s\n", topic.c_str(), dds_strretcode(-made));
    if (made > 0) out.push_back(made);
    return made > 0;
  }

  const dds_entity_t participant_;
  std::vector<dds_entity_t> writers_, readers_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const auto participant =
      dds_create_participant(static_cast<dds_domainid_t>(std::atoi(argv[2])), nullptr, nullptr);
  if (participant < 0) return 3;
  Cyclone stack(participant);
  const int code = steady::Peer(stack, argv[1]).serve();
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  return code;
}
