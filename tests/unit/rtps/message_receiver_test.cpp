// The submessages of a message that each endpoint gets, and where an invalid submessage ends the
// message.
#include "rtps/participant/message_receiver.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps/wire_helpers.hpp"
#include "wire/heartbeat.hpp"
#include "wire/info_destination.hpp"
#include "wire/info_source.hpp"

namespace ddssec::rtps {
namespace {

using testing::code_of;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::written;

const auto kOurs = GuidPrefix::from(Bytes(12, 1));
const auto kPeer = GuidPrefix::from(Bytes(12, 2));
const auto kOther = GuidPrefix::from(Bytes(12, 3));

// A participant without endpoints.
struct NoEndpoints final : EndpointLookup {
  std::span<StatefulReader* const> readers_of(const Guid&) override { return {}; }
  StatefulWriter* writer_for(const EntityId&, const GuidPrefix&) override { return nullptr; }
  bool sends_keys(const GuidPrefix&) override { return true; }
  bool marks_ends(const GuidPrefix&) override { return true; }
};

struct Heard final : MessageListener {
  Status on_announcement(const GuidPrefix& source, const Data&) override {
    announced.push_back(source);
    return announcement;
  }
  void on_stateless(const GuidPrefix& source, BytesView) override { stateless.push_back(source); }
  void on_stateless_frag(const GuidPrefix&, const DataFrag&) override {}
  void on_builtin_heartbeat(const Guid& writer) override { heartbeats.push_back(writer); }
  void on_alive(const Guid&) override {}
  void on_acknack(const GuidPrefix&, const AckNack&, bool) override {}
  void on_key_exchange(const GuidPrefix&) override {}
  void on_message(const GuidPrefix& source, const SignsOfLife& signs) override {
    sources.push_back(source);
    directed.push_back(signs.is_directed);
  }

  Status announcement;
  std::vector<GuidPrefix> announced, stateless, sources;
  std::vector<bool> directed;
  std::vector<Guid> heartbeats;
};

struct MessageReceiverTest : ::testing::Test {
  MessageReceiverTest()
      : receiver(kOurs, endpoints, heard, counters,
                 [this](const GuidPrefix& source, const Error& error, EventOrigin origin) {
                   reported.emplace_back(source, error.code(), origin);
                 }) {}

  static Bytes from(const GuidPrefix& source, std::initializer_list<Bytes> submessages) {
    auto octets = testing::message(submessages);
    std::ranges::copy(source.octets, octets.begin() + 8);
    return octets;
  }
  void receive(std::initializer_list<Bytes> submessages, const GuidPrefix& source = kPeer) {
    receiver.receive(from(source, submessages), std::chrono::seconds(1));
  }

  static Bytes heartbeat() {
    return written(Heartbeat{kEntityIdUnknown, kPublicationsWriter, {1}, {1}, 1, false, false});
  }
  static Bytes stateless() {
    static const Bytes payload(8);
    return written(Data{
        kStatelessMessageReader, kStatelessMessageWriter, {1}, {}, PayloadKind::data, payload});
  }
  static Bytes announcement() {
    static const Bytes payload(8);
    return written(Data{kSpdpReader, kSpdpWriter, {1}, {}, PayloadKind::data, payload});
  }
  // A HEARTBEAT with four octets is too short.
  static Bytes invalid() { return {0x07, 0x01, 4, 0, 0, 0, 0, 0}; }

  NoEndpoints endpoints;
  Heard heard;
  ParticipantCounters counters;
  std::vector<std::tuple<GuidPrefix, Code, EventOrigin>> reported;
  MessageReceiver receiver;
};

TEST_F(MessageReceiverTest, MessageOfTheParticipantItself_IsIgnored) {
  receive({heartbeat(), announcement()}, kOurs);
  EXPECT_EQ(counters.messages, 1u);
  EXPECT_EQ(counters.malformed, 0u);
  EXPECT_THAT(heard.announced, IsEmpty());
  EXPECT_THAT(heard.heartbeats, IsEmpty());
  EXPECT_THAT(heard.sources, IsEmpty());
}

TEST_F(MessageReceiverTest, NoHeader_IsCountedAndReportedWithoutASource) {
  receiver.receive(Bytes{'R', 'T', 'P', 'X'}, std::chrono::seconds(1));
  EXPECT_EQ(counters.messages, 1u);
  EXPECT_EQ(counters.malformed, 1u);
  ASSERT_EQ(reported.size(), 1u);
  EXPECT_EQ(std::get<0>(reported[0]), GuidPrefix{});
  EXPECT_EQ(std::get<2>(reported[0]), EventOrigin::anyone);
  EXPECT_THAT(heard.sources, IsEmpty());
}

// RTPS 8.3.4.1.
TEST_F(MessageReceiverTest, InvalidSubmessage_EndsTheMessageAndKeepsWhatCameBefore) {
  receive({heartbeat(), invalid(), heartbeat(), announcement()});
  EXPECT_EQ(heard.heartbeats.size(), 1u);
  EXPECT_THAT(heard.announced, IsEmpty());
  EXPECT_EQ(counters.malformed, 1u);
  ASSERT_EQ(reported.size(), 1u);
  EXPECT_EQ(std::get<0>(reported[0]), kPeer);
  EXPECT_EQ(std::get<2>(reported[0]), EventOrigin::anyone);
  EXPECT_THAT(heard.sources, ElementsAre(kPeer)) << "what came before still shows that it is alive";
}

TEST_F(MessageReceiverTest, AnnouncementThatCannotBeRead_EndsTheMessage) {
  heard.announcement = fail(Code::truncated);
  receive({announcement(), heartbeat()});
  EXPECT_THAT(heard.announced, ElementsAre(kPeer));
  EXPECT_THAT(heard.heartbeats, IsEmpty());
  ASSERT_EQ(reported.size(), 1u);
  EXPECT_EQ(std::get<1>(reported[0]), Code::truncated);
}

TEST_F(MessageReceiverTest, UnknownSubmessage_IsSteppedOver) {
  receive({Bytes{0x7e, 0x01, 4, 0, 1, 2, 3, 4}, heartbeat()});
  EXPECT_EQ(heard.heartbeats.size(), 1u);
  EXPECT_EQ(counters.malformed, 0u);
}

// Without keys, the group cannot be opened.
TEST_F(MessageReceiverTest, ProtectedGroupWithoutKeys_IsSteppedOver) {
  receive({Bytes{0x31, 0x01, 4, 0, 1, 2, 3, 4}, heartbeat()});
  EXPECT_EQ(heard.heartbeats.size(), 1u);
  EXPECT_EQ(counters.malformed, 0u);
}

TEST_F(MessageReceiverTest, InfoDestination_NamesTheReceiverOfTheNextSubmessages) {
  receive({written(InfoDestination{kOther}), heartbeat(), stateless(),
           written(InfoDestination{kOurs}), heartbeat(), written(InfoDestination{kOther}),
           heartbeat(), written(InfoDestination{}), stateless()});
  EXPECT_EQ(heard.heartbeats.size(), 1u);
  EXPECT_EQ(heard.stateless.size(), 1u);
  EXPECT_THAT(heard.directed, ElementsAre(true));
}

TEST_F(MessageReceiverTest, MessageToEveryParticipant_IsNotDirected) {
  receive({written(InfoDestination{}), heartbeat()});
  EXPECT_THAT(heard.directed, ElementsAre(false));
}

TEST_F(MessageReceiverTest, InfoSource_IsTheSourceOfTheNextSubmessages) {
  InfoSource other;
  other.source.prefix = kOther;
  receive({heartbeat(), written(other), heartbeat(), stateless()});
  EXPECT_THAT(heard.heartbeats,
              ElementsAre(Guid{kPeer, kPublicationsWriter}, Guid{kOther, kPublicationsWriter}));
  EXPECT_THAT(heard.stateless, ElementsAre(kOther));
  EXPECT_THAT(heard.sources, ElementsAre(kPeer, kOther)) << "each source by itself";
}

// Nothing else would stop such a message: data protection does not cover a dispose without a
// payload, and there are no keys for a source that is this participant itself.
TEST_F(MessageReceiverTest, InfoSourceOfTheParticipantItself_LetsNothingCount) {
  InfoSource own, other;
  own.source.prefix = kOurs;
  other.source.prefix = kOther;
  receive({written(own), heartbeat(), stateless(), written(InfoDestination{kOurs}), heartbeat(),
           announcement(), written(other), heartbeat()});
  EXPECT_THAT(heard.heartbeats, ElementsAre(Guid{kOther, kPublicationsWriter}));
  EXPECT_THAT(heard.stateless, IsEmpty());
  EXPECT_THAT(heard.announced, IsEmpty());
}

TEST_F(MessageReceiverTest, MessageCutOffAnywhere_ReachesNoOneTwiceAndIsNeverReadPastItsEnd) {
  const auto whole = from(kPeer, {heartbeat(), stateless(), announcement()});
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    heard = {};
    receiver.receive(cut, std::chrono::seconds(1));
    EXPECT_LE(heard.heartbeats.size(), 1u) << size;
    EXPECT_LE(heard.stateless.size(), 1u) << size;
    EXPECT_THAT(heard.announced, IsEmpty()) << size;
  }
  receiver.receive(whole, std::chrono::seconds(1));
  EXPECT_EQ(heard.announced.size(), 1u);
}

}  // namespace
}  // namespace ddssec::rtps
