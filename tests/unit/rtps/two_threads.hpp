// Two participants of one process, each with a thread.
#pragma once

#include <barrier>
#include <cstdlib>
#include <future>

#include "base/plugin_services.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps::two_threads {

using namespace testing;

/// Acts once, in the participant's thread, when data arrives for the first time.
struct Once final : DataReaderListener {
  std::function<void()> act;
  std::promise<void> done;
  bool has_acted = false;
  void on_data_available(AnyDataReader& reader) override {
    Samples<Reading> samples;
    static_cast<void>(static_cast<DataReader<Reading>&>(reader).take(samples));
    if (std::exchange(has_acted, true)) return;
    act();
    done.set_value();
  }
};

inline DomainParticipantOptions own_thread() {
  return {.domain_id = static_cast<DomainId>(::getpid() % 200 + 30),
          .domain_tag = "listeners " + std::to_string(::getpid()),
          .interfaces = {"127.0.0.1"},
          .multicast = false};
}

/// Two participants with threads of their own, each with a writer and a reader with a listener.
struct TwoThreads : ::testing::Test {
  const SystemClock clock;
  SystemRandom random;
  test::RecordedEvents events;
  PluginServices services{clock, random, events};
  struct Side {
    explicit Side(const PluginServices& services) : end(services, own_thread()) {
      reader->set_listener(&listener, StatusKind::data_available);
    }
    End end;
    DataWriter<Reading>* writer = &end.writer();
    DataReader<Reading>* reader = &end.reader(reliable());
    Once listener;
  };
  std::unique_ptr<Side> a = std::make_unique<Side>(services);
  std::unique_ptr<Side> b = std::make_unique<Side>(services);
  std::barrier<> both{2};

  /// Lets both listeners run at the same time. A deadlock cannot be undone, so it ends the test
  /// program.
  void run() {
    auto first = a->listener.done.get_future(), second = b->listener.done.get_future();
    ASSERT_TRUE(a->writer->write({"north", 1}));
    ASSERT_TRUE(b->writer->write({"north", 1}));
    for (auto* done : {&first, &second}) {
      if (done->wait_for(20s) == std::future_status::ready) continue;
      std::fprintf(stderr, "the listeners wait for each other for good\n");
      std::_Exit(EXIT_FAILURE);
    }
  }
};

}  // namespace ddssec::rtps::two_threads
