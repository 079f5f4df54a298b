// A writer and a reader of two participants.
#pragma once

#include "rtps/reliability/stateful_reader.hpp"
#include "tests/support/succeeds.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps::accesses {

using namespace std::chrono_literals;
using test::succeeds;
using testing::reliable;

struct Access : testing::Polled {
  DataWriter<Reading>& writer = a.writer(reliable());
  DataReader<Reading>& reader = b.reader(reliable());
  Samples<Reading> samples;
  void SetUp() override { ASSERT_TRUE(match(writer, reader)); }
  void write(const char* sensor, std::int64_t value) {
    ASSERT_TRUE(succeeds(writer.write({sensor, value})));
    run();
  }
};

struct Heard final : DomainParticipantListener {
  std::vector<std::string> calls;
  MatchedStatus matched;
  IncompatibleQosStatus incompatible;
  Status deleting;
  AnyDataReader* to_delete = nullptr;
  void on_data_available(AnyDataReader& reader) override {
    calls.push_back("data");
    if (to_delete != nullptr) deleting = reader.subscriber().delete_datareader(*to_delete);
  }
  void on_data_on_readers(Subscriber&) override { calls.push_back("readers"); }
  void on_subscription_matched(AnyDataReader&, const MatchedStatus& s) override {
    calls.push_back("subscription"), matched = s;
  }
  void on_publication_matched(AnyDataWriter&, const MatchedStatus& s) override {
    calls.push_back("publication"), matched = s;
  }
  void on_requested_incompatible_qos(AnyDataReader&, const IncompatibleQosStatus& s) override {
    calls.push_back("requested"), incompatible = s;
  }
  void on_offered_incompatible_qos(AnyDataWriter&, const IncompatibleQosStatus& s) override {
    calls.push_back("offered"), incompatible = s;
  }
  void on_inconsistent_topic(Topic&, const InconsistentTopicStatus&) override {
    calls.push_back("topic");
  }
  void on_offered_deadline_missed(AnyDataWriter&, const DeadlineMissedStatus&) override {
    calls.push_back("offered deadline");
  }
  void on_requested_deadline_missed(AnyDataReader&, const DeadlineMissedStatus&) override {
    calls.push_back("requested deadline");
  }
  void on_liveliness_lost(AnyDataWriter&, const LivelinessLostStatus&) override {
    calls.push_back("lost");
  }
  void on_liveliness_changed(AnyDataReader&, const LivelinessChangedStatus&) override {
    calls.push_back("liveliness");
  }
  void on_sample_rejected(AnyDataReader&, const SampleRejectedStatus&) override {
    calls.push_back("rejected");
  }
  void on_sample_lost(AnyDataReader&, const SampleLostStatus&) override {
    calls.push_back("sample lost");
  }
  bool heard(const std::string& call) {
    const bool is = std::ranges::find(calls, call) != calls.end();
    calls.clear();
    return is;
  }
};

}  // namespace ddssec::rtps::accesses
