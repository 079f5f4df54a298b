// ContentFilteredTopic, QueryCondition and TIME_BASED_FILTER between two participants.
#include "rtps/dcps/wait_set.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

struct ContentFilteredTopicTest : Polled {
  ContentFilteredTopic& filtered(std::string expression, std::vector<std::string> parameters = {},
                                 std::string name = "FewReadings") {
    auto topic = b.participant->create_contentfilteredtopic(
        std::move(name), *b.topic, {std::move(expression), std::move(parameters)});
    EXPECT_TRUE(topic) << topic.error().to_sentence();
    return **topic;
  }
  DataReader<Reading>& reader(ContentFilteredTopic& topic, const Qos& qos = reliable()) {
    return **b.subscriber->create_datareader<Reading>(topic, qos);
  }
  // Reads until there are that many samples, and then a while longer to show that nothing else
  // arrives.
  std::vector<std::int64_t> all_of(DataReader<Reading>& reader, std::size_t count) {
    std::vector<std::int64_t> out;
    const auto take = [&] {
      for (auto value : taken(reader)) out.push_back(value);
      return out.size() >= count;
    };
    eventually(take);
    run(50ms);
    take();
    return out;
  }
};

TEST_P(ContentFilteredTopicTest, Readers_GetWhatPasses) {
  auto& writer = a.writer();
  auto& few = reader(filtered("value BETWEEN %0 AND %1 AND sensor LIKE 'no%'", {"2", "3"}));
  auto& all = b.reader(reliable());
  ASSERT_TRUE(match(writer, few));
  ASSERT_TRUE(match(writer, all));
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(writer.write({"north", i}));
  ASSERT_TRUE(writer.write({"south", 2}));
  EXPECT_EQ(all_of(all, 7).size(), 7u);
  EXPECT_EQ(all_of(few, 2), (std::vector<std::int64_t>{2, 3}));
  EXPECT_EQ(few.sample_lost_status().total_count, 0);
  EXPECT_EQ(few.content_filtered_topic()->name(), "FewReadings");
  EXPECT_EQ(all.content_filtered_topic(), nullptr);
}

// RTPS 2.5, 8.7.3: the writer applies the filter and sends GAP. Everything is acknowledged.
TEST_P(ContentFilteredTopicTest, SamplesThatDoNotPass_AreNotSent) {
  auto& writer = a.writer();
  auto& few = reader(filtered("value > 97"));
  ASSERT_TRUE(match(writer, few));
  run(300ms);
  const auto before = b.participant->counters().messages;
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(writer.write({"north", i, Bytes(1000, 1)}));
  EXPECT_EQ(all_of(few, 2), (std::vector<std::int64_t>{98, 99}));
  EXPECT_LT(b.participant->counters().messages - before, 40u);
  EXPECT_TRUE(eventually([&] { return writer.wait_for_acknowledgments(0ms).has_value(); }));
}

TEST_P(ContentFilteredTopicTest, EachReader_HasItsOwnFilter) {
  auto& writer = a.writer();
  auto& low = reader(filtered("value < 3", {}, "Low"));
  auto& high = reader(filtered("value >= 3", {}, "High"));
  Qos lazy;
  lazy.history.kind = HistoryKind::keep_all;
  auto& best_effort = reader(filtered("value = 4", {}, "Four"), lazy);
  for (auto* each : {&low, &high, &best_effort}) ASSERT_TRUE(match(writer, *each));
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(writer.write({"north", i}));
  EXPECT_EQ(all_of(low, 3), (std::vector<std::int64_t>{0, 1, 2}));
  EXPECT_EQ(all_of(high, 3), (std::vector<std::int64_t>{3, 4, 5}));
  EXPECT_EQ(all_of(best_effort, 1), (std::vector<std::int64_t>{4}));
  for (auto* each : {&low, &high, &best_effort})
    EXPECT_EQ(each->sample_lost_status().total_count, 0);
}

TEST_P(ContentFilteredTopicTest, ALateJoiner_GetsOfTheHistoryWhatPasses) {
  auto qos = default_writer_qos();
  qos.durability = DurabilityKind::transient_local;
  qos.history = {HistoryKind::keep_all, 1};
  auto& writer = a.writer(qos);
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(writer.write({"north", i}));
  for (const auto kind : {ReliabilityKind::reliable, ReliabilityKind::best_effort}) {
    auto late = reliable();
    late.reliability.kind = kind;
    late.durability = DurabilityKind::transient_local;
    auto& few =
        reader(filtered("value > 3", {}, kind == ReliabilityKind::reliable ? "R" : "B"), late);
    ASSERT_TRUE(match(writer, few));
    EXPECT_EQ(all_of(few, 2), (std::vector<std::int64_t>{4, 5}));
  }
}

TEST_P(ContentFilteredTopicTest, Parameters_ChangeForTheSamplesToCome) {
  auto& writer = a.writer();
  auto& topic = filtered("value = %0", {"1"});
  auto& few = reader(topic);
  ASSERT_TRUE(match(writer, few));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer.write({"north", i}));
  EXPECT_EQ(all_of(few, 1), (std::vector<std::int64_t>{1}));
  ASSERT_TRUE(topic.set_expression_parameters({"2"}));
  EXPECT_EQ(topic.expression_parameters(), std::vector<std::string>{"2"});
  EXPECT_EQ(topic.filter_expression(), "value = %0");
  run(100ms);  // the writer learns of the change
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer.write({"north", i}));
  EXPECT_EQ(all_of(few, 1), (std::vector<std::int64_t>{2}));
  EXPECT_EQ(code_of(topic.set_expression_parameters({})), Code::rtps_filter_invalid);
  EXPECT_EQ(code_of(topic.set_expression_parameters({"'x'"})), Code::rtps_filter_invalid);
  EXPECT_EQ(topic.expression_parameters(), std::vector<std::string>{"2"});
}

// RTPS 2.5, 8.7.4: the reader learns only of the ends of instances that it saw.
TEST_P(ContentFilteredTopicTest, AReader_HearsOfTheEndOfWhatItSaw) {
  auto& writer = a.writer();
  auto& few = reader(filtered("value > 3"));
  ASSERT_TRUE(match(writer, few));
  ASSERT_TRUE(writer.write({"seen", 4}));
  ASSERT_TRUE(writer.write({"unseen", 1}));
  ASSERT_TRUE(writer.write({"seen", 1}));
  ASSERT_TRUE(writer.dispose({"unseen"}));
  ASSERT_TRUE(writer.dispose({"seen"}));
  Samples<Reading> samples;
  ASSERT_TRUE(eventually([&] { return few.read(samples) && samples.size() == 2; }));
  run(50ms);
  ASSERT_TRUE(few.take(samples));
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[0].data.value, 4);
  EXPECT_FALSE(samples[1].info.valid_data);
  EXPECT_EQ(samples[1].data.sensor, "seen");
  EXPECT_EQ(samples[1].info.instance_state, InstanceState::not_alive_disposed);
}

TEST_P(ContentFilteredTopicTest, SamplesInFragments_AreFilteredToo) {
  auto& writer = a.writer();
  auto& few = reader(filtered("value = 2"));
  ASSERT_TRUE(match(writer, few));
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(writer.write({"north", i, Bytes(50000, 1)}));
  EXPECT_EQ(all_of(few, 1), (std::vector<std::int64_t>{2}));
}

// The writer sends everything without a filter result, and the reader filters itself.
TEST_P(ContentFilteredTopicTest, AnExpressionThatTakesTooLong_IsAppliedByItsReaderAlone) {
  auto& writer = a.writer();
  std::string expression = "value = 2";
  while (expression.size() < 3000) expression += " OR sensor LIKE '%ab'";
  auto& few = reader(filtered(expression));
  ASSERT_TRUE(match(writer, few));
  run(300ms);
  const auto before = b.participant->counters().messages;
  const std::string sensor(20, 'a');
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(writer.write({sensor, i, Bytes(50'000, 1)}));
  EXPECT_EQ(all_of(few, 1), (std::vector<std::int64_t>{2}));
  if (GetParam() == Way::network) {
    EXPECT_GE(b.participant->counters().messages - before, 4u);
  }
  EXPECT_EQ(few.sample_lost_status().total_count, 0);
}

TEST_P(ContentFilteredTopicTest, ATakenName_IsToldWithTheCallThatReturnsItsTopic) {
  filtered("value = 1", {}, "F");
  const auto hint = [&](const std::string& name) {
    const auto plain = b.participant->create_topic<Reading>(name);
    const auto filter = b.participant->create_contentfilteredtopic(name, *b.topic, {"value = 1"});
    if (plain || filter) return std::string();
    EXPECT_EQ(plain.error().hint(), filter.error().hint());
    return plain.error().hint();
  };
  EXPECT_EQ(
      hint("Readings"),
      "lookup_topicdescription(\"Readings\") returns the one that has the name; or choose another");
  EXPECT_EQ(
      hint("F"),
      "lookup_contentfilteredtopic(\"F\") returns the one that has the name; or choose another");
}

TEST_P(ContentFilteredTopicTest, WhatCannotBeUsed_IsRefused) {
  const auto create = [&](std::string name, Topic& topic, std::string expression) {
    return code_of(b.participant->create_contentfilteredtopic(std::move(name), topic,
                                                              {std::move(expression)}));
  };
  EXPECT_EQ(create("F", *b.topic, "valu = 1"), Code::rtps_filter_invalid);
  EXPECT_EQ(create("F", *b.topic, ""), Code::rtps_filter_invalid);
  EXPECT_EQ(create("F", *b.topic, "value = %0"), Code::rtps_filter_invalid);
  EXPECT_EQ(create("", *b.topic, "value = 1"), Code::rtps_bad_parameter);
  EXPECT_EQ(create(std::string(257, 'x'), *b.topic, "value = 1"), Code::rtps_bad_parameter);
  EXPECT_EQ(create("Readings", *b.topic, "value = 1"), Code::rtps_precondition_not_met);
  EXPECT_EQ(create("F", *a.topic, "value = 1"), Code::rtps_precondition_not_met);
  auto* octets = *b.participant->create_topic("Octets", TypeSupport{.name = "Unknown"});
  EXPECT_EQ(create("F", *octets, "value = 1"), Code::rtps_filter_invalid);
  filtered("value = 1", {}, "F");
  EXPECT_EQ(create("F", *b.topic, "value = 1"), Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(b.participant->create_topic<Reading>("F")), Code::rtps_precondition_not_met);
}

TEST_P(ContentFilteredTopicTest, TopicInUse_IsDeletedAfterItsReadersAndBeforeItsTopic) {
  auto& topic = filtered("value = 1");
  EXPECT_EQ(b.participant->lookup_contentfilteredtopic("FewReadings"), &topic);
  auto& few = reader(topic);
  EXPECT_EQ(code_of(b.participant->delete_contentfilteredtopic(topic)),
            Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(a.participant->delete_contentfilteredtopic(topic)),
            Code::rtps_precondition_not_met);
  ASSERT_TRUE(b.subscriber->delete_datareader(few));
  EXPECT_EQ(code_of(b.participant->delete_topic(*b.topic)), Code::rtps_precondition_not_met);
  ASSERT_TRUE(b.participant->delete_contentfilteredtopic(topic));
  EXPECT_EQ(b.participant->lookup_contentfilteredtopic("FewReadings"), nullptr);
  ASSERT_TRUE(b.participant->delete_topic(*b.topic));
}

TEST_P(ContentFilteredTopicTest, WhatCannotBeRead_DoesNotPass) {
  auto* octets = *a.publisher->create_datawriter(*a.topic, default_writer_qos());
  auto& few = reader(filtered("value <> 77"));
  ASSERT_TRUE(match(*octets, few));
  const Bytes broken{0, 1, 0, 0, 255, 255, 255, 255};
  ASSERT_TRUE(octets->write_octets({.payload = broken, .key = KeyHash{}}));
  EXPECT_TRUE(eventually([&] { return few.malformed() == 1; }));
  EXPECT_TRUE(taken(few).empty());
}

struct QueryConditionTest : ContentFilteredTopicTest {};

TEST_P(QueryConditionTest, Expression_FindsWhatItAsksFor) {
  auto& writer = a.writer();
  auto& all = b.reader(reliable());
  auto& query = **all.create_querycondition({.sample = SampleState::not_read},
                                            {"value >= %0 AND sensor = 'north'", {"3"}});
  ASSERT_TRUE(match(writer, all));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer.write({"north", i}));
  ASSERT_TRUE(writer.write({"south", 5}));
  ASSERT_TRUE(eventually([&] {
    Samples<Reading> samples;
    return all.read(samples) && samples.size() == 4;
  }));
  EXPECT_FALSE(query.trigger_value());
  for (int i = 3; i < 5; ++i) ASSERT_TRUE(writer.write({"north", i}));
  ASSERT_TRUE(eventually([&] { return query.trigger_value(); }));
  run(50ms);
  Samples<Reading> samples;
  ASSERT_TRUE(all.take_w_condition(samples, query));
  EXPECT_EQ(values(samples), (std::vector<std::int64_t>{3, 4}));
  EXPECT_FALSE(query.trigger_value());
  ASSERT_TRUE(all.take_next_instance_w_condition(samples, {}, query));
  EXPECT_TRUE(samples.empty());
  ASSERT_TRUE(all.take(samples));
  EXPECT_EQ(values(samples).size(), 4u);
}

TEST_P(QueryConditionTest, Parameters_ChangeWhatItFinds) {
  auto& writer = a.writer();
  auto& all = b.reader(reliable());
  auto& query = **all.create_querycondition({}, {"value = %0", {"9"}});
  ASSERT_TRUE(match(writer, all));
  ASSERT_TRUE(writer.write({"north", 1}));
  run(100ms);
  EXPECT_FALSE(query.trigger_value());
  ASSERT_TRUE(query.set_query_parameters({"1"}));
  EXPECT_TRUE(query.trigger_value());
  EXPECT_EQ(query.query_parameters(), std::vector<std::string>{"1"});
  EXPECT_EQ(query.query_expression(), "value = %0");
  EXPECT_EQ(code_of(query.set_query_parameters({"x"})), Code::rtps_filter_invalid);
  EXPECT_TRUE(query.trigger_value());
  EXPECT_TRUE(all.delete_readcondition(query));
}

TEST_P(QueryConditionTest, AnEmptyExpression_FindsAll) {
  auto& writer = a.writer();
  auto& all = b.reader(reliable());
  auto& query = **all.create_querycondition({}, {" "});
  ASSERT_TRUE(match(writer, all));
  ASSERT_TRUE(writer.write({"north", 1}));
  EXPECT_TRUE(eventually([&] { return query.trigger_value(); }));
  EXPECT_TRUE(query.set_query_parameters({"1"}));
  EXPECT_EQ(code_of(all.create_querycondition({}, {"value >"})), Code::rtps_filter_invalid);
  EXPECT_EQ(all_of(all, 1), (std::vector<std::int64_t>{1}));
}

struct TimeBasedFilterTest : ContentFilteredTopicTest {
  Qos separated(ReliabilityKind kind) {
    auto qos = reliable();
    qos.reliability.kind = kind;
    qos.time_based_filter = Duration::from(200ms);
    return qos;
  }
};

TEST_P(TimeBasedFilterTest, EachInstance_ComesAtMostSoOften) {
  auto& writer = a.writer();
  auto& slow = b.reader(separated(ReliabilityKind::best_effort));
  auto& quick = b.reader(reliable());
  ASSERT_TRUE(match(writer, slow));
  ASSERT_TRUE(match(writer, quick));
  for (int i = 0; i < 50; ++i) {
    ASSERT_TRUE(writer.write({"north", i}));
    ASSERT_TRUE(writer.write({"south", 100 + i}));
    run(20ms);
  }
  EXPECT_EQ(all_of(quick, 100).size(), 100u);
  const auto few = all_of(slow, 10);
  EXPECT_EQ(std::ranges::count_if(few, [](auto v) { return v < 100; }), 5);
  EXPECT_EQ(std::ranges::count_if(few, [](auto v) { return v >= 100; }), 5);
}

// DDS 1.4, 2.2.3.12: a reliable reader has the last sample in the end.
TEST_P(TimeBasedFilterTest, AReliableReader_GetsTheLastSample) {
  auto& writer = a.writer();
  auto& slow = b.reader(separated(ReliabilityKind::reliable));
  ASSERT_TRUE(match(writer, slow));
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(writer.write({"north", i}));
  ASSERT_TRUE(eventually([&] {
    Samples<Reading> samples;
    return slow.read(samples) && samples.size() == 1;
  }));
  run(100ms);
  EXPECT_EQ(taken(slow), (std::vector<std::int64_t>{0}));
  run(200ms);
  EXPECT_EQ(taken(slow), (std::vector<std::int64_t>{9}));
  run(500ms);
  EXPECT_TRUE(taken(slow).empty());
}

TEST_P(TimeBasedFilterTest, ADisposedInstance_DoesNotComeBack) {
  auto& writer = a.writer();
  auto& slow = b.reader(separated(ReliabilityKind::reliable));
  ASSERT_TRUE(match(writer, slow));
  ASSERT_TRUE(writer.write({"north", 1}));
  ASSERT_TRUE(writer.write({"north", 2}));
  ASSERT_TRUE(writer.dispose({"north"}));
  run(500ms);
  Samples<Reading> samples;
  ASSERT_TRUE(slow.take(samples));
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[0].data.value, 1);
  EXPECT_EQ(samples[1].info.instance_state, InstanceState::not_alive_disposed);
}

TEST_P(TimeBasedFilterTest, SeparationOfARunningReader_IsChangeable) {
  auto& writer = a.writer();
  auto qos = separated(ReliabilityKind::reliable);
  auto& slow = b.reader(qos);
  ASSERT_TRUE(match(writer, slow));
  ASSERT_TRUE(writer.write({"north", 1}));
  ASSERT_TRUE(writer.write({"north", 2}));
  run(50ms);
  EXPECT_EQ(taken(slow), (std::vector<std::int64_t>{1}));
  qos.time_based_filter = kDurationZero;
  ASSERT_TRUE(slow.set_qos(qos));
  run(50ms);
  ASSERT_TRUE(writer.write({"north", 3}));
  run(50ms);
  EXPECT_EQ(taken(slow), (std::vector<std::int64_t>{2, 3}));
}

#define INSTANTIATE(suite) \
  INSTANTIATE_TEST_SUITE_P(Over, suite, ::testing::Values(Way::network, Way::in_process), name_of)
INSTANTIATE(ContentFilteredTopicTest);
INSTANTIATE(QueryConditionTest);
INSTANTIATE(TimeBasedFilterTest);

}  // namespace
}  // namespace ddssec::rtps
