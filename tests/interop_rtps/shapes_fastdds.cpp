// A shapes program on Fast DDS in its default configuration: -P|-S DOMAIN TOPIC.
#include <cstdio>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <thread>

#include "interop/peers/fastdds_shape.hpp"

namespace {

using namespace interop_fast;

// The type of shapes_type.idl: the interop type without its payload.
class FinalShape final : public ShapeType {
 public:
  FinalShape() : ShapeType("ShapeType") {}

 private:
  void write(Cdr& cdr, const void* sample) const override {
    const auto& shape = *static_cast<const Shape*>(sample);
    cdr << shape.color << shape.x << shape.y << shape.shapesize;
  }
  void read(Cdr& cdr, void* sample) const override {
    auto& shape = *static_cast<Shape*>(sample);
    cdr >> shape.color >> shape.x >> shape.y >> shape.shapesize;
  }
};

void publish(fdds::DataWriter& writer) {
  Shape shape;
  shape.color = "GREEN";
  for (;; ++shape.shapesize, std::this_thread::sleep_for(std::chrono::milliseconds(33)))
    writer.write(&shape);
}

void subscribe(fdds::DataReader& reader, const char* topic) {
  for (;; std::this_thread::sleep_for(std::chrono::milliseconds(50))) {
    Shape shape;
    fdds::SampleInfo info;
    while (ok(reader.take_next_sample(&shape, &info))) {
      if (info.valid_data)
        std::printf("%-10s %-10s %03d %03d [%d]\n", topic, shape.color.c_str(), shape.x, shape.y,
                    shape.shapesize);
      // The end of an instance may come together with its last sample.
      if (info.instance_state != fdds::ALIVE_INSTANCE_STATE)
        std::printf("%-10s %s\n", topic,
                    info.instance_state == fdds::NOT_ALIVE_DISPOSED_INSTANCE_STATE ? "disposed"
                                                                                   : "no writers");
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 1;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  log_to_stderr();
  auto* participant = fdds::DomainParticipantFactory::get_instance()->create_participant(
      static_cast<unsigned>(std::atoi(argv[2])), fdds::PARTICIPANT_QOS_DEFAULT);
  fdds::TypeSupport type(new FinalShape);
  type.register_type(participant);
  auto* topic = participant->create_topic(argv[3], "ShapeType", fdds::TOPIC_QOS_DEFAULT);
  if (std::strcmp(argv[1], "-P") == 0) {
    auto* publisher = participant->create_publisher(fdds::PUBLISHER_QOS_DEFAULT);
    auto qos = fdds::DATAWRITER_QOS_DEFAULT;
    publish(*publisher->create_datawriter(topic, qos));
  } else {
    auto* subscriber = participant->create_subscriber(fdds::SUBSCRIBER_QOS_DEFAULT);
    auto qos = fdds::DATAREADER_QOS_DEFAULT;
    qos.reliability().kind = fdds::RELIABLE_RELIABILITY_QOS;
    subscribe(*subscriber->create_datareader(topic, qos), argv[3]);
  }
  return 0;
}
