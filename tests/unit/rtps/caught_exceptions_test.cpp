// A listener that throws.
#include "rtps/dcps/caught_exceptions.hpp"

#include <future>

#include "tests/unit/rtps/dcps_fixture.hpp"
#include "tests/unit/rtps/two_threads.hpp"

namespace ddssec::rtps::two_threads {
namespace {

using namespace testing;

TEST_F(TwoThreads, AListenerThatThrows_IsReported_AndTheParticipantGoesOn) {
  std::promise<void> further;
  struct Throws final : DataReaderListener {
    std::promise<void>* further = nullptr;
    int calls = 0;
    void on_data_available(AnyDataReader& reader) override {
      Samples<Reading> samples;
      static_cast<void>(static_cast<DataReader<Reading>&>(reader).take(samples));
      if (++calls == 4) further->set_value();
      if (calls == 1) throw std::bad_alloc();
      if (calls == 2) throw std::runtime_error("no disk");
      if (calls == 3) throw 42;
    }
  } throws;
  throws.further = &further;
  b->listener.act = [] {};  // it gets the samples, too
  a->reader->set_listener(&throws);
  auto reached = further.get_future();
  for (int i = 0; i < 1000 && reached.wait_for(10ms) != std::future_status::ready; ++i)
    ASSERT_TRUE(a->writer->write({"north", i}));
  EXPECT_EQ(reached.wait_for(0s), std::future_status::ready);
  EXPECT_EQ(a->end.participant->counters().exceptions, 3u);
  a->reader->set_listener(nullptr);
  const std::lock_guard held(events.mutex);
  EXPECT_EQ(std::ranges::count(events.all, Code::rtps_exception,
                               [](const Event& event) { return event.error.code(); }),
            2);
}

}  // namespace
}  // namespace ddssec::rtps::two_threads
