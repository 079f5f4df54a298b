// QueryConditions: how often samples are evaluated, and which samples are found when samples, their
// states and the parameters change.
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using Values = std::vector<std::int64_t>;

// Counts the samples that filters decode.
class CountingView final : public SampleView {
 public:
  explicit CountingView(std::size_t& count) : count_(count) {
    leaves_.assign(view_.leaves().begin(), view_.leaves().end());
  }
  Status decode(BytesView payload, std::size_t members) override {
    ++count_;
    return view_.decode(payload, members);
  }

 private:
  std::size_t& count_;
  SampleViewOf<Reading> view_;
};

struct QueryMatchesTest : Polled {
  std::size_t evaluations = 0;
  Qos offered = reliable();
  Topic* topic = nullptr;
  Publisher* publisher = nullptr;
  DataWriter<Reading>* writer = nullptr;
  DataReader<Reading>* reader = nullptr;

  void start(const Qos& qos = reliable(), const Presentation& access = {}) {
    auto type = type_support<Reading>();
    type.view = [this] { return std::make_unique<CountingView>(evaluations); };
    topic = *a.participant->create_topic<Reading>("Counted");
    auto& here = **b.participant->create_topic("Counted", std::move(type));
    publisher = &a.participant->create_publisher({.presentation = access});
    auto& subscriber = b.participant->create_subscriber({.presentation = access});
    offered.destination_order = qos.destination_order;
    reader = *subscriber.create_datareader<Reading>(here, qos);
    writer = &another_writer();
  }
  DataWriter<Reading>& another_writer() {
    auto& out = **publisher->create_datawriter<Reading>(*topic, offered);
    EXPECT_TRUE(match(out, *reader));
    return out;
  }
  void arrive(DataWriter<Reading>& all_of) {
    EXPECT_TRUE(eventually([&] { return all_of.wait_for_acknowledgments(0ms).has_value(); }));
  }
  // Writes `count` samples of as many instances, or of one.
  void write(std::int64_t first, std::int64_t count, bool one_instance = false) {
    for (auto i = first; i < first + count; ++i)
      ASSERT_TRUE(writer->write({one_instance ? "one" : std::to_string(i), i}));
    arrive(*writer);
  }
  QueryCondition& query(std::string expression, std::vector<std::string> parameters = {},
                        const States& states = {}) {
    return **reader->create_querycondition(states, {std::move(expression), std::move(parameters)});
  }
  Values read(const ReadCondition& condition, std::int32_t most = kLengthUnlimited) {
    Samples<Reading> samples;
    EXPECT_TRUE(reader->read_w_condition(samples, condition, most));
    return values(samples);
  }
  Values take(const ReadCondition& condition, std::int32_t most = kLengthUnlimited) {
    Samples<Reading> samples;
    EXPECT_TRUE(reader->take_w_condition(samples, condition, most));
    return values(samples);
  }
};

TEST_P(QueryMatchesTest, ASampleIsEvaluatedOnce_WhateverIsHeld) {
  start();
  auto& found = query("value >= 500");
  write(0, 300);
  EXPECT_FALSE(found.trigger_value());
  EXPECT_EQ(evaluations, 300u);
  write(500, 3);
  EXPECT_TRUE(found.trigger_value());
  EXPECT_EQ(read(found), (Values{500, 501, 502}));
  EXPECT_EQ(take(found, 2), (Values{500, 501}));
  EXPECT_EQ(take(found), (Values{502}));
  EXPECT_FALSE(found.trigger_value());
  EXPECT_EQ(evaluations, 303u);
  EXPECT_EQ(taken(*reader).size(), 300u);
  EXPECT_EQ(evaluations, 303u);
}

TEST_P(QueryMatchesTest, ReaderWithoutQueryConditions_EvaluatesNothing) {
  start();
  write(0, 10);
  auto& every = reader->create_readcondition({});
  auto& found = query("value > 100");
  EXPECT_TRUE(reader->delete_readcondition(found));
  const auto before = evaluations;
  EXPECT_EQ(before, 10u);  // from the time when it was created
  write(10, 10);
  EXPECT_TRUE(every.trigger_value());
  EXPECT_EQ(evaluations, before);
}

TEST_P(QueryMatchesTest, NewParameters_AreAppliedToWhatIsHeld) {
  start();
  write(0, 20);
  auto& found = query("value < %0", {"3"});
  EXPECT_EQ(read(found), (Values{0, 1, 2}));
  ASSERT_TRUE(found.set_query_parameters({"0"}));
  EXPECT_FALSE(found.trigger_value());
  EXPECT_TRUE(read(found).empty());
  ASSERT_TRUE(found.set_query_parameters({"2"}));
  EXPECT_TRUE(found.trigger_value());
  EXPECT_EQ(take(found), (Values{0, 1}));
  EXPECT_EQ(evaluations, 60u);
  EXPECT_EQ(take(query("value < 5")), (Values{2, 3, 4}));
}

TEST_P(QueryMatchesTest, ReplacedSamples_AreNoLongerFound) {
  start(reliable(HistoryKind::keep_last));
  auto& found = query("value >= 100");
  write(100, 5, true);
  EXPECT_EQ(read(found), (Values{104}));
  write(1, 1, true);
  EXPECT_FALSE(found.trigger_value());
  EXPECT_TRUE(read(found).empty());
}

TEST_P(QueryMatchesTest, States_DecideWithTheQuery) {
  start();
  auto& unread = query("value >= 100", {}, {.sample = SampleState::not_read});
  auto& seen = query("value >= 100", {}, {.sample = SampleState::read});
  auto& ended = query("value >= 100", {}, {.instance = InstanceState::not_alive_disposed});
  write(0, 5);
  write(100, 2);
  EXPECT_TRUE(unread.trigger_value());
  EXPECT_FALSE(seen.trigger_value());
  EXPECT_EQ(read(unread, 1), (Values{100}));
  EXPECT_TRUE(unread.trigger_value());
  EXPECT_TRUE(seen.trigger_value());
  EXPECT_EQ(read(unread), (Values{101}));
  EXPECT_FALSE(unread.trigger_value());
  ASSERT_TRUE(writer->dispose({"0"}));
  run(20ms);
  EXPECT_FALSE(ended.trigger_value());
  ASSERT_TRUE(writer->dispose({"101"}));
  run(20ms);
  EXPECT_TRUE(ended.trigger_value());
  EXPECT_EQ(take(ended), (Values{101}));
  EXPECT_FALSE(ended.trigger_value());
  EXPECT_EQ(take(seen), (Values{100}));
}

TEST_P(QueryMatchesTest, NextInstance_SkipsThoseThatDoNotPass) {
  start();
  auto& found = query("value >= 100 AND value < 103");
  write(0, 5);
  write(100, 5);
  write(102, 1);
  Samples<Reading> samples;
  InstanceHandle previous;
  for (const auto& expected : {Values{100}, Values{101}, Values{102, 102}}) {
    ASSERT_TRUE(reader->read_next_instance_w_condition(samples, previous, found));
    ASSERT_EQ(values(samples), expected);
    previous = samples[0].info.instance_handle;
  }
  ASSERT_TRUE(reader->read_next_instance_w_condition(samples, previous, found));
  EXPECT_TRUE(samples.empty());
}

TEST_P(QueryMatchesTest, SourceOrder_SamplesOfAnInstanceStayInOrder) {
  auto qos = reliable();
  qos.destination_order = DestinationOrderKind::by_source;
  start(qos);
  auto& found = query("value >= 100");
  auto& late = another_writer();  // another writer, because the times of one writer never go back
  const auto begin = clock.calendar_nanoseconds();
  const auto write_at = [&](DataWriter<Reading>& from, int i) {
    for (const int value : {i, 100 + i})
      ASSERT_TRUE(from.write_w_timestamp({"one", value}, {}, Time::from(begin + i * 1ms)));
    arrive(from);
  };
  write_at(*writer, 3), write_at(late, 1), write_at(late, 2);
  EXPECT_EQ(read(found), (Values{101, 102, 103}));
}

TEST_P(QueryMatchesTest, OrderedAccess_KeepsTheOrderOfArrival) {
  start(reliable(), {PresentationScope::topic, false, true});
  auto& found = query("value >= 100");
  for (const int i : {0, 101, 100, 1, 103, 102})
    ASSERT_TRUE(writer->write({i % 2 == 0 ? "even" : "odd", i}));
  run(20ms);
  EXPECT_EQ(read(found, 1), (Values{101}));
  EXPECT_EQ(read(found), (Values{101, 100, 103, 102}));
  EXPECT_EQ(take(found, 2), (Values{101, 100}));
  EXPECT_EQ(taken(*reader), (Values{0, 1, 103, 102}));
  EXPECT_FALSE(found.trigger_value());
  EXPECT_EQ(evaluations, 6u);
}

TEST_P(QueryMatchesTest, OneThatIsUpdatedAllTheTime_LeavesTheOthersTheirTurn) {
  start();
  auto& found = query("value >= 100");
  write(100, 3);
  EXPECT_EQ(take(found, 1), (Values{100}));
  write(100, 1);
  EXPECT_EQ(take(found, 1), (Values{101}));
  EXPECT_EQ(take(found, 1), (Values{102}));
  EXPECT_EQ(take(found, 1), (Values{100}));
}

INSTANTIATE_TEST_SUITE_P(Over, QueryMatchesTest, ::testing::Values(Way::network, Way::in_process),
                         name_of);

}  // namespace
}  // namespace ddssec::rtps
