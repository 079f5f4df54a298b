// Endpoints whose rights renewed permissions have changed: what access control counts.
#include "plugins/cyclonedds/own_endpoints.hpp"

#include <future>

#include <gtest/gtest.h>

#include "tests/unit/cyclonedds/access_control_adapters.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds {
namespace {

using testing::_;
using testing::Return;
using namespace std::chrono_literals;

constexpr spi::PermissionsHandle kUs{8}, kOther{9};

Status denied(std::string topic, Code code = Code::publish_not_allowed) {
  return fail(code, {.document = "permissions.p7s", .line = 7, .expected = std::move(topic)});
}

struct OwnEndpointsTest : testing::Test {
  OwnEndpointsTest() {
    ON_CALL(plugin, renewals).WillByDefault([this](auto) { return renewals; });
    ON_CALL(plugin, check_own_endpoint).WillByDefault([this](auto, bool writes, const auto& asked) {
      const bool is_lost = lost == asked.topic_name;
      return is_lost ? denied(lost, writes ? Code::publish_not_allowed : code_for_readers)
                     : Status();
    });
    ON_CALL(plugin, find_unknown_right).WillByDefault([this](auto, const auto& asked) {
      const auto at =
          std::ranges::find(asked, unknown, [](auto& one) { return one.request.topic_name; });
      return at == asked.end() ? std::nullopt : std::optional<std::size_t>(at - asked.begin());
    });
    endpoints.add(&writer, kUs, true, {.topic_name = "Square"});
    endpoints.add(&reader, kUs, false, {.topic_name = "Circle"});
  }

  // One look of the timer, a second after the one before.
  std::optional<Error> poll(spi::PermissionsHandle local = kUs) {
    return endpoints.poll(local, plugin, now += 1s);
  }

  testing::NiceMock<MockAccessControl> plugin;
  std::chrono::nanoseconds now{};
  std::uint64_t renewals = 0;
  std::string lost, unknown;
  Code code_for_readers = Code::subscribe_not_allowed;
  OwnEndpoints endpoints;
  const int writer = 0, reader = 0;  // only their addresses count
};

TEST_F(OwnEndpointsTest, EndpointsWithoutARenewal_AreNotJudged) {
  lost = "Square";
  EXPECT_CALL(plugin, check_own_endpoint).Times(0);
  EXPECT_FALSE(poll());
}

TEST_F(OwnEndpointsTest, RightsThatStay_AreJudgedOnceForEachRenewal) {
  renewals = 1;
  EXPECT_CALL(plugin, check_own_endpoint(kUs, true, _)).Times(1);
  EXPECT_CALL(plugin, check_own_endpoint(kUs, false, _)).Times(1);
  EXPECT_FALSE(poll());
  EXPECT_FALSE(poll());
  EXPECT_EQ(endpoints.changes(kUs), 0u);
}

TEST_F(OwnEndpointsTest, ALostRight_IsToldOnce) {
  renewals = 1;
  lost = "Square";
  const auto told = poll();
  ASSERT_TRUE(told);
  EXPECT_EQ(told->code(), Code::own_rights_lost);
  EXPECT_EQ(told->details().document, "permissions.p7s");
  EXPECT_EQ(told->details().expected, "Square");
  EXPECT_EQ(endpoints.changes(kUs), 1u);
  renewals = 2;  // a right that was lost before does not count again
  EXPECT_FALSE(poll());
  lost.clear();
  renewals = 3;
  EXPECT_FALSE(poll());
  lost = "Square";
  renewals = 4;
  EXPECT_TRUE(poll());
  EXPECT_EQ(endpoints.changes(kUs), 2u);
}

TEST_F(OwnEndpointsTest, SeveralLostRights_AreOneLossAndAreCounted) {
  endpoints.add(&endpoints, kUs, true, {.topic_name = "Square"});
  endpoints.add(&plugin, kOther, true, {.topic_name = "Square"});
  renewals = 1;
  lost = "Square";
  const auto told = poll();
  ASSERT_TRUE(told);
  EXPECT_NE(told->details().note.find("1 more endpoints"), std::string::npos);
  EXPECT_EQ(endpoints.changes(kUs), 1u);
  EXPECT_EQ(endpoints.changes(kOther), 0u);
}

TEST_F(OwnEndpointsTest, AnEndpointThatIsGone_LosesNothing) {
  renewals = 1;
  lost = "Square";
  endpoints.remove(&writer);
  EXPECT_FALSE(poll());
  endpoints.add(&writer, kUs, true, {.topic_name = "Square"});
  endpoints.forget(kUs);
  EXPECT_FALSE(poll());
}

// A participant without valid permissions is cut off altogether.
TEST_F(OwnEndpointsTest, PermissionsThatEnded_AreNoLostRight) {
  renewals = 1;
  lost = "Circle";
  code_for_readers = Code::grant_expired;
  EXPECT_FALSE(poll());
}

TEST_F(OwnEndpointsTest, PartitionsAndTags_AreJudged) {
  const std::vector<std::string_view> partitions = {"p", "q"};
  const spi::PropertyList tags = {{"colour", "red"}};
  endpoints.add(&tags, kOther, true,
                {.topic_name = "Square", .partitions = partitions, .data_tags = tags});
  renewals = 1;
  EXPECT_CALL(plugin, check_own_endpoint(kOther, true, _)).WillOnce([&](auto, bool, auto& asked) {
    EXPECT_TRUE(std::ranges::equal(asked.partitions, partitions));
    EXPECT_EQ(asked.data_tags.size(), 1u);
    return Status();
  });
  EXPECT_FALSE(poll(kOther));
}

// ---- rights that peers do not know

TEST_F(OwnEndpointsTest, ARightThatPeersDoNotKnow_IsToldOnceForEachRenewal) {
  unknown = "Circle";
  EXPECT_CALL(plugin, find_unknown_right).Times(0);
  EXPECT_FALSE(poll()) << "nothing was renewed";
  testing::Mock::VerifyAndClearExpectations(&plugin);
  renewals = 1;
  const auto told = poll();
  ASSERT_TRUE(told);
  EXPECT_EQ(told->code(), Code::own_rights_gained);
  EXPECT_EQ(told->details().document, "the reader of topic Circle");
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(poll());
  EXPECT_EQ(endpoints.changes(kUs), 1u);
  renewals = 2;
  EXPECT_TRUE(poll());
  EXPECT_EQ(endpoints.changes(kUs), 2u);
  EXPECT_EQ(endpoints.changes(kOther), 0u);
}

TEST_F(OwnEndpointsTest, ARightThatComesBack_IsAGain) {
  renewals = 1;
  lost = unknown = "Square";
  EXPECT_EQ(poll()->code(), Code::own_rights_lost);
  EXPECT_FALSE(poll()) << "a right that the endpoint does not have";
  lost.clear();
  renewals = 2;
  EXPECT_EQ(poll()->code(), Code::own_rights_gained);
}

TEST_F(OwnEndpointsTest, EndpointThatOnlyTheNewPermissionsAllow_IsAGain) {
  unknown = "Triangle";
  renewals = 1;
  EXPECT_FALSE(poll());
  endpoints.add(&plugin, kUs, true, {.topic_name = "Triangle"});
  const auto told = poll();
  ASSERT_TRUE(told);
  EXPECT_EQ(told->details().document, "the writer of topic Triangle");
}

TEST_F(OwnEndpointsTest, EndpointsMadeInALoop_EndNoSessionsInALoop) {
  renewals = 1;
  for (int i = 0; i < 100; ++i) {
    unknown = std::to_string(i);
    endpoints.add(&plugin, kUs, true, {.topic_name = unknown});
    poll();
    endpoints.remove(&plugin);
  }
  EXPECT_EQ(endpoints.changes(kUs), 1u);
}

TEST_F(OwnEndpointsTest, ALossAndAGainByTheSamePermissions_AreOneChange) {
  renewals = 1;
  lost = "Square";
  unknown = "Circle";
  EXPECT_EQ(poll()->code(), Code::own_rights_lost);
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(poll());
  EXPECT_EQ(endpoints.changes(kUs), 1u);
}

TEST_F(OwnEndpointsTest, HandshakeThatWasUnderWay_IsFoundByTheSecondQuestion) {
  renewals = 1;
  EXPECT_CALL(plugin, find_unknown_right(kUs, _))
      .WillOnce(Return(std::nullopt))
      .WillOnce(Return(0));
  int polls = 1;
  while (!poll() && polls < 100) ++polls;
  EXPECT_EQ(polls, 13);
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(poll());
}

// The timer looks more often while something ends.
TEST_F(OwnEndpointsTest, TheSecondQuestion_ComesAfterTwelveSecondsHoweverManyLooks) {
  renewals = 1;
  EXPECT_CALL(plugin, find_unknown_right).WillOnce(Return(std::nullopt));
  for (; now < 12s; now += 50ms) EXPECT_FALSE(endpoints.poll(kUs, plugin, now));
  testing::Mock::VerifyAndClearExpectations(&plugin);
  EXPECT_CALL(plugin, find_unknown_right).WillOnce(Return(std::nullopt));
  for (; now < 36s; now += 50ms) EXPECT_FALSE(endpoints.poll(kUs, plugin, now));
}

// An attacker can hold back the answer of the peer for longer.
TEST_F(OwnEndpointsTest, HandshakeThatEndsLate_IsFoundByALaterQuestion) {
  renewals = 1;
  for (int i = 0; i < 30; ++i) EXPECT_FALSE(poll());
  unknown = "Square";
  int polls = 1;
  while (!poll() && polls < 100) ++polls;
  EXPECT_EQ(polls, 7) << "24 seconds after the second question";
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(poll());
  EXPECT_EQ(endpoints.changes(kUs), 1u);
}

TEST_F(OwnEndpointsTest, RightsThatPeersKnow_AreAskedForAllAtOnceAfterTwiceTheTime) {
  EXPECT_CALL(plugin, find_unknown_right(kUs, testing::SizeIs(2)))
      .Times(8)
      .WillRepeatedly(Return(std::nullopt));
  for (renewals = 1; renewals <= 2; ++renewals)
    for (int i = 0; i < 100; ++i) EXPECT_FALSE(poll());
}

TEST_F(OwnEndpointsTest, RightsThatPeersKnow_AreAskedForEachTenMinutesAtLast) {
  renewals = 1;
  for (int i = 0; i < 2000; ++i) EXPECT_FALSE(poll());
  EXPECT_CALL(plugin, find_unknown_right).Times(3).WillRepeatedly(Return(std::nullopt));
  for (int i = 0; i < 1800; ++i) EXPECT_FALSE(poll());
}

using access_control_adapters::AccessControlAdapterTest;

// An adapter with a local participant that was allowed its writer of "Square".
struct LostRightsTest : AccessControlAdapterTest {
  void SetUp() override {
    ON_CALL(plugin, validate_local_permissions).WillByDefault(Return(kUs));
    ON_CALL(plugin, next_expiry).WillByDefault(Return(std::nullopt));
    ON_CALL(plugin, datawriter_sec_attributes).WillByDefault([this](auto&&...) {
      spi::EndpointSecurityAttributes out;
      out.is_builtin = is_builtin;
      return out;
    });
    ON_CALL(plugin, check_own_endpoint).WillByDefault([](auto&&...) { return denied("Square"); });
    EXPECT_EQ(c->validate_local_permissions(c, nullptr, 1, 5, &qos, nullptr), kUs.value);
    EXPECT_EQ(c->get_datawriter_sec_attributes(c, kUs.value, "Square", nullptr, nullptr,
                                               &attributes, nullptr),
              1);
    ON_CALL(plugin, renewals(kUs)).WillByDefault(Return(1));
  }
  // Runs the work of the timer.
  void expire() {
    const dds_security_access_control_listener listener{
        [](const dds_security_access_control*,
           const DDS_Security_PermissionsHandle) -> DDS_Security_boolean { return 1; }};
    std::promise<void> ran;
    EXPECT_CALL(plugin, next_expiry).WillOnce([&] {
      ran.set_value();
      return std::optional<WallTime>();
    });
    EXPECT_EQ(c->set_listener(c, &listener, nullptr), 1);
    ran.get_future().wait();
    EXPECT_EQ(c->set_listener(c, nullptr, nullptr), 1);
  }
  std::uint64_t changes() const { return AccessControlAdapter::rights_changed({1}); }

  bool is_builtin = false;
  DDS_Security_EndpointSecurityAttributes attributes{};
};

TEST_F(LostRightsTest, RightsOfAnEndpoint_AreReportedAndCounted) {
  expire();
  EXPECT_EQ(changes(), 1u);
  ASSERT_FALSE(harness.events.empty());
  EXPECT_EQ(harness.events.back().error.code(), Code::own_rights_lost);
  EXPECT_EQ(AccessControlAdapter::rights_changed({2}), 0u);
}

TEST_F(LostRightsTest, RightsThatPeersDoNotKnow_AreReportedAndCounted) {
  ON_CALL(plugin, check_own_endpoint).WillByDefault(Return(Status()));
  ON_CALL(plugin, find_unknown_right(kUs, _)).WillByDefault(Return(0));
  expire();
  expire();
  EXPECT_EQ(changes(), 1u);
  EXPECT_EQ(std::ranges::count(harness.events, Code::own_rights_gained,
                               [](const auto& event) { return event.error.code(); }),
            1);
  EXPECT_EQ(AccessControlAdapter::rights_changed({2}), 0u);
}

TEST_F(LostRightsTest, RightsOfADeletedEndpoint_AreNotReported) {
  EXPECT_EQ(c->return_datawriter_sec_attributes(c, &attributes, nullptr), 1);
  expire();
  EXPECT_EQ(changes(), 0u);
}

TEST_F(LostRightsTest, RightsOfABuiltinEndpoint_AreNotReported) {
  is_builtin = true;
  EXPECT_EQ(c->return_datawriter_sec_attributes(c, &attributes, nullptr), 1);
  EXPECT_EQ(c->get_datawriter_sec_attributes(c, kUs.value, "DCPSPublications", nullptr, nullptr,
                                             &attributes, nullptr),
            1);
  expire();
  EXPECT_EQ(changes(), 0u);
}

TEST_F(OwnEndpointsTest, AQuestionThatFoundNoMemory_IsAskedAgain) {
  renewals = 1;
  unknown = "Square";
  EXPECT_CALL(plugin, find_unknown_right)
      .WillOnce(testing::Throw(std::bad_alloc()))
      .WillOnce(Return(0u));
  EXPECT_THROW(poll(), std::bad_alloc);
  EXPECT_EQ(endpoints.changes(kUs), 0u);
  const auto told = poll();
  ASSERT_TRUE(told);
  EXPECT_EQ(told->code(), Code::own_rights_gained);
  EXPECT_EQ(endpoints.changes(kUs), 1u);
}

}  // namespace
}  // namespace ddssec::cyclonedds
