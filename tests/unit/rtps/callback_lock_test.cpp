// Listeners that act on another participant of the process, destroy a participant, or throw.
#include "rtps/dcps/callback_lock.hpp"

#include <cstdlib>
#include <future>

#include "tests/unit/rtps/dcps_fixture.hpp"
#include "tests/unit/rtps/two_threads.hpp"

namespace ddssec::rtps::two_threads {
namespace {

using namespace testing;

struct PrintedEvents final : EventSink {
  void raise(const Event& event) override { std::fprintf(stderr, "%s\n", event.to_line().c_str()); }
};

// Each listener must not hold the lock that the other one's call needs.
TEST_F(TwoThreads, ListenersThatCreateOnTheOtherParticipant_BothSucceed) {
  std::atomic<int> created = 0;
  for (auto [own, other] : {std::pair{a.get(), b.get()}, std::pair{b.get(), a.get()}})
    own->listener.act = [&, other] {
      both.arrive_and_wait();
      auto& end = other->end;
      const auto topic = end.participant->create_topic<Reading>("Further");
      auto& publisher = end.participant->create_publisher({.autoenable_created_entities = false});
      if (!topic) return;
      const auto writer = publisher.create_datawriter<Reading>(**topic);
      Once ignored;
      const auto reader = end.subscriber->create_datareader<Reading>(**topic, reliable(), &ignored);
      if (!writer || !reader || !publisher.enable() || !(*writer)->enable()) return;
      (*reader)->set_listener(nullptr);
      ++created;
    };
  run();
  EXPECT_EQ(created, 2);
}

TEST_F(TwoThreads, ListenersThatDeleteOnTheOtherParticipant_OneIsRefused) {
  std::atomic<int> deleted = 0, refused = 0;
  for (auto [own, other] : {std::pair{a.get(), b.get()}, std::pair{b.get(), a.get()}})
    own->listener.act = [&, other] {
      both.arrive_and_wait();
      const auto outcome = other->end.publisher->delete_datawriter(*other->writer);
      if (outcome) ++deleted;
      if (code_of(outcome) == Code::rtps_precondition_not_met) ++refused;
    };
  run();
  EXPECT_EQ(deleted, 1);
  EXPECT_EQ(refused, 1);
  EXPECT_EQ((a->end.publisher->lookup_datawriter("Readings") == nullptr) +
                (b->end.publisher->lookup_datawriter("Readings") == nullptr),
            1)
      << "what was refused changed nothing";
}

TEST_F(TwoThreads, ListenersThatReplaceEachOther_BothReturn) {
  std::atomic<int> returned = 0;
  for (auto [own, other] : {std::pair{a.get(), b.get()}, std::pair{b.get(), a.get()}})
    own->listener.act = [&, other] {
      both.arrive_and_wait();
      other->reader->set_listener(nullptr);
      ++returned;
    };
  run();
  EXPECT_EQ(returned, 2);
}

TEST_F(TwoThreads, AParticipantDestroyedWhileItsListenerDeletesElsewhere_Ends) {
  std::atomic<int> refused = 0;
  b->listener.act = [&] {
    both.arrive_and_wait();
    if (code_of(a->end.publisher->delete_datawriter(*a->writer)) == Code::rtps_precondition_not_met)
      ++refused;
  };
  a->listener.act = [&] {
    both.arrive_and_wait();
    b->end.participant.reset();
  };
  run();
  EXPECT_EQ(refused, 1);
}

// The listener is one of a builtin reader: the participant has no entities of its own that would
// prevent its deletion.
TEST_F(TwoThreads, TheFactory_DoesNotDeleteAParticipantInItsListener) {
  DomainParticipantFactory factory(services);
  auto* participant = *factory.create_participant(own_thread());
  struct Deletes final : DataReaderListener {
    std::function<Code()> act;
    std::promise<Code> outcome;
    bool has_acted = false;
    void on_data_available(AnyDataReader&) override {
      if (!std::exchange(has_acted, true)) outcome.set_value(act());
    }
  } deletes;
  deletes.act = [&] { return code_of(factory.delete_participant(*participant)); };
  auto outcome = deletes.outcome.get_future();
  auto* reader = participant->builtin_datareader<PublicationBuiltinTopicData>();
  reader->set_listener(&deletes, StatusKind::data_available);
  a->end.writer();
  ASSERT_EQ(outcome.wait_for(20s), std::future_status::ready);
  EXPECT_EQ(outcome.get(), Code::rtps_precondition_not_met);
  reader->set_listener(nullptr);
  EXPECT_TRUE(factory.delete_participant(*participant));
}

using PolledListeners = Polled;

// A sample of the participant's own writer calls the listener of its reader.
void act_in_listener(End& end, Once& listener, std::function<void()> act) {
  listener.act = std::move(act);
  auto& writer = end.writer();
  end.reader(reliable()).set_listener(&listener);
  for (int i = 0; i < 5 && end.participant; ++i) {
    static_cast<void>(writer.write({"north", i}));
    end.participant->poll(0ms);
  }
}

TEST_P(PolledListeners, AListenerThatServesAnotherParticipant_IsStillProtected) {
  Once outer, inner;
  Code outcome = Code::internal;
  act_in_listener(a, outer, [&] {
    act_in_listener(b, inner, [&] { outcome = code_of(a.publisher->delete_contained_entities()); });
  });
  EXPECT_TRUE(inner.has_acted);
  EXPECT_EQ(outcome, Code::rtps_precondition_not_met);
  a.subscriber->lookup_datareader("Readings")->set_listener(nullptr);
  b.subscriber->lookup_datareader("Readings")->set_listener(nullptr);
}

// Otherwise the listener and its participant would be used after their end.
TEST_P(PolledListeners, AParticipantDestroyedInItsOwnListener_EndsTheProcessWithAReason) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  PrintedEvents printed;
  const PluginServices loud{clock, random, printed};
  auto options = this->options();
  EXPECT_DEATH(
      {
        End end(loud, options);
        Once listener;
        act_in_listener(end, listener, [&] { end.participant.reset(); });
        std::_Exit(0);
      },
      "rtps_ended_in_listener 1746");
  options.own_thread = true;
  EXPECT_DEATH(
      {
        End end(loud, options);
        Once listener;
        listener.act = [&] { end.participant.reset(); };
        auto& writer = end.writer();
        end.reader(reliable()).set_listener(&listener);
        static_cast<void>(writer.write({"north", 1}));
        std::this_thread::sleep_for(20s);
        std::_Exit(0);
      },
      "rtps_ended_in_listener 1746");
}

INSTANTIATE_TEST_SUITE_P(Over, PolledListeners, ::testing::Values(Way::network, Way::in_process),
                         [](const auto& info) { return testing::name_of(info); });

}  // namespace
}  // namespace ddssec::rtps::two_threads
