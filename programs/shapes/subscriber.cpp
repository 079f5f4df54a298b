// Option -S: prints the received samples once a period.
#include "programs/shapes/session.hpp"

namespace ddssec::shapes {
namespace {

template <class T>
class SubscriberRun {
 public:
  explicit SubscriberRun(Session& session) : session_(session), options_(session.options()) {}

  int run() {
    const auto topics = session_.create_topics<T>();
    if (!topics) return not_created("topic", topics.error());
    auto& subscriber = session_.participant().create_subscriber(session_.group_qos());
    for (auto* topic : *topics) {
      auto reader = create_reader(subscriber, *topic);
      if (!reader) return not_created("datareader", reader.error());
      readers_.push_back(*reader);
    }
    return read(subscriber);
  }

 private:
  Result<rtps::DataReader<T>*> create_reader(rtps::Subscriber& subscriber, rtps::Topic& topic) {
    const auto filter = session_.filter();
    if (!filter) {
      print_line("Create reader for topic: %s", topic.name().c_str());
      return subscriber.create_datareader<T>(topic, session_.reader_qos());
    }
    const auto filtered = session_.participant().create_contentfilteredtopic(
        topic.name() + "_filtered", topic, *filter);
    if (!filtered) {
      print_line("failed to create content filtered topic");
      return std::unexpected(filtered.error());
    }
    print_line("Create reader for topic: %s", topic.name().c_str());
    return subscriber.create_datareader<T>(**filtered, session_.reader_qos());
  }

  int read(rtps::Subscriber& subscriber) {
    const auto& presentation = options_.presentation;
    const bool accesses = presentation.coherent_access || presentation.ordered_access;
    for (std::uint64_t n = 0; options_.iterations == 0 || n < options_.iterations; ++n) {
      const auto iteration = static_cast<unsigned long long>(n);
      if (presentation.coherent_access)
        print_line("Reading coherent sets, iteration %llu", iteration);
      if (presentation.ordered_access)
        print_line("Reading with ordered access, iteration %llu", iteration);
      if (accesses && !subscriber.begin_access()) return kRunFailed;
      for (auto* reader : readers_)
        if (!read_all(*reader)) return kRunFailed;
      if (accesses && !subscriber.end_access()) return kRunFailed;
      if (!session_.pause(options_.read_period)) break;
    }
    return kDone;
  }

  bool read_all(rtps::DataReader<T>& reader) {
    rtps::InstanceHandle previous;
    for (;;) {
      const auto found = next(reader, previous);
      if (!found) return print_line("failed to read"), false;
      if (*found == 0) return true;
      for (const auto& sample : samples_) say_one(reader, sample);
      previous = samples_[0].info.instance_handle;
      if (!options_.by_instance) return true;  // all samples were read at once
    }
  }

  Result<std::size_t> next(rtps::DataReader<T>& reader, rtps::InstanceHandle previous) {
    if (!options_.by_instance) return options_.read ? reader.read(samples_) : reader.take(samples_);
    return options_.read ? reader.read_next_instance(samples_, previous)
                         : reader.take_next_instance(samples_, previous);
  }

  void say_one(rtps::DataReader<T>& reader, const rtps::Sample<T>& sample) {
    const auto& topic = reader.topic().name();
    if (sample.info.valid_data) return print_sample(topic, sample.data);
    const auto key = reader.key_value(sample.info.instance_handle);
    const auto& color = key ? key->color : sample.data.color;
    if (sample.info.instance_state == rtps::InstanceState::not_alive_no_writers)
      print_line("%-10s %-10s NOT_ALIVE_NO_WRITERS_INSTANCE_STATE", topic.c_str(), color.c_str());
    if (sample.info.instance_state == rtps::InstanceState::not_alive_disposed)
      print_line("%-10s %-10s NOT_ALIVE_DISPOSED_INSTANCE_STATE", topic.c_str(), color.c_str());
  }

  Session& session_;
  const Options& options_;
  std::vector<rtps::DataReader<T>*> readers_;
  rtps::Samples<T> samples_;
};

}  // namespace

template <class T>
int run_subscriber(Session& session) {
  return SubscriberRun<T>(session).run();
}
template int run_subscriber<ShapeType>(Session&);
template int run_subscriber<FinalShapeType>(Session&);

}  // namespace ddssec::shapes
