// What a refusal says: the document, the rule and the values, and no more than it may.
#include "plugins/access_control/refusals.hpp"

#include "tests/unit/access_control/access_control_fixture.hpp"
#include "tests/unit/access_control/decisions.hpp"

namespace ddssec::access_control {
namespace {

using spi::EndpointRequest;

TEST_F(Decisions, ARefusal_SaysThatOnlyThePartitionIsNotAllowed) {
  auto allowed = publish_rule(true, {"closed"});
  allowed.publish[0].partitions = {{{"p", 0}}};
  const Partitions wrong = {"q"};
  const EndpointRequest request{.topic_name = "closed", .partitions = wrong};
  const auto peer = peer_with({allowed});
  for (const auto& refused : {plugin->check_create_datawriter(with({allowed}), 0, request),
                              plugin->check_remote_datawriter(peer, 0, request)}) {
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().hint().find("the topic is allowed, but not in partition \"q\""),
              std::string::npos)
        << refused.error().hint();
  }
}

TEST_F(Decisions, ANameThatIsClose_IsProposedToTheLocalParticipantOnly) {
  const auto allowed = publish_rule(true, {"closed_chatter"});
  const EndpointRequest request{.topic_name = "closed_chater"};
  const auto own = plugin->check_create_datawriter(with({allowed}), 0, request);
  const auto peers = plugin->check_remote_datawriter(peer_with({allowed}), 0, request);
  ASSERT_FALSE(own);
  ASSERT_FALSE(peers);
  EXPECT_NE(own.error().hint().find("is \"closed_chatter\" meant?"), std::string::npos);
  EXPECT_EQ(peers.error().hint().find("is \"closed_chatter\" meant?"), std::string::npos);
}

TEST_F(Decisions, ATopicOfRos_IsAllowedByThePolicyFirst) {
  governance_document.domain_rules[0].topic_rules = {{.topic_expression = "*"}};
  const auto own = with({rule(true)});
  const auto writer = plugin->check_create_datawriter(own, 0, {.topic_name = "rt/secret"});
  const auto topic = plugin->check_create_topic(own, 0, "rt/secret");
  const auto peers =
      plugin->check_remote_datawriter(peer_with({rule(true)}), 0, {.topic_name = "rt/secret"});
  ASSERT_FALSE(writer || topic || peers);
  for (const auto& error : {writer.error(), topic.error()})
    EXPECT_TRUE(error.hint().starts_with("in a keystore of ROS 2, allow the topic"))
        << error.hint();
  EXPECT_NE(peers.error().hint().find("in a keystore of ROS 2, allow the topic"),
            std::string::npos);
}

TEST_F(Decisions, ARefusedPeer_IsToldApartFromTheLocalParticipant) {
  const auto peer = peer_with({publish_rule(true, {"closed_out"})});
  const auto own = with({publish_rule(true, {"closed_out"})});
  const auto mentions = [](std::string_view text, std::string_view part) {
    return text.find(part) != text.npos;
  };
  const EndpointRequest request{.topic_name = "closed_in"};
  const auto reader = plugin->check_remote_datareader(peer, 0, request);
  const auto writer = plugin->check_remote_datawriter(peer, 0, request);
  const auto topic = plugin->check_remote_topic(peer, 0, "closed_in");
  ASSERT_FALSE(reader || writer || topic);
  for (const auto& error : {reader.error(), writer.error(), topic.error()}) {
    EXPECT_TRUE(mentions(error.details().note, "the peer's own permissions, grant"))
        << error.details().note;
    EXPECT_TRUE(mentions(error.hint(), std::string("the permissions of ") + kListener + " decide"))
        << error.hint();
    EXPECT_TRUE(mentions(error.hint(), info(error.code()).hint)) << error.hint();
    EXPECT_EQ(log.all.empty() ? "" : log.all.front().peer_subject, kListener);
  }
  const auto ours = plugin->check_create_datawriter(own, 0, {.topic_name = "closed_in"});
  ASSERT_FALSE(ours);
  EXPECT_FALSE(mentions(ours.error().details().note, "peer"));
  EXPECT_EQ(ours.error().hint(), info(Code::publish_not_allowed).hint);
  // The announcement behind a match may be forged, so that hint stays.
  const auto matched = plugin->check_remote_match(peer, match({.topic_name = "closed_in"}));
  ASSERT_FALSE(matched);
  EXPECT_EQ(matched.error().hint(), info(Code::match_not_permitted).hint);
}

// Anyone can announce an endpoint in a peer's name if discovery is not protected, and any
// participant can if its origin is not authenticated.
TEST_F(Decisions, AnAnnouncementInAPeersName_DoesNotAccuseThePeer) {
  const auto peer = peer_with({rule(true)});
  const auto writer = plugin->check_remote_datawriter(peer, 0, {.topic_name = "closed_in"});
  const auto reader = plugin->check_remote_datareader(peer, 0, {.topic_name = "closed_in"});
  ASSERT_FALSE(writer);
  ASSERT_FALSE(reader);
  EXPECT_EQ(writer.error().code(), Code::announced_writer_not_allowed);
  EXPECT_EQ(reader.error().code(), Code::announced_reader_not_allowed);
  for (const auto& error : {writer.error(), reader.error()})
    EXPECT_NE(error.hint().find("this does not prove that the peer made the announcement"),
              std::string::npos)
        << error.hint();
  for (const auto& event : log.all) EXPECT_EQ(event.severity, Severity::warning);
}

TEST_F(Decisions, Refusal_NamesDocumentLineRuleAndValues) {
  const auto handle = with({publish_rule(false, {"closed_b"}), publish_rule(true, {"closed_*"})});
  const Partitions partitions = {""};
  const auto status = plugin->check_create_datawriter(
      handle, 0, {.topic_name = "closed_b", .partitions = partitions});
  ASSERT_FALSE(status);
  const auto& details = status.error().details();
  EXPECT_EQ(details.document, "dds.sec.access.permissions");
  EXPECT_EQ(details.line, 25);  // the line of the file
  EXPECT_EQ(details.field, "<deny_rule>");
  EXPECT_EQ(details.expected, "an allow_rule to publish topic \"closed_b\" in partition \"\"");
  EXPECT_NE(details.note.find(kTalker), std::string::npos);
}

}  // namespace
}  // namespace ddssec::access_control
