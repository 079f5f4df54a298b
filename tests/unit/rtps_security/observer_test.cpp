// What an observer concludes about participants that meet, or do not meet.
#include "rtps/observer/meetings.hpp"
#include "tests/unit/rtps_security/security_fixture.hpp"
#include "wire/data.hpp"
#include "wire/info_source.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

bool contains(const Bytes& datagram, std::string_view text) {
  return as_text(datagram).find(text) != std::string_view::npos;
}

// Hears the messages of a pair that arrive.
struct Listening {
  using Lets = std::function<bool(const Node& from, const Bytes& datagram)>;
  explicit Listening(Pair& pair, Lets lets = {}) {
    pair.world.filter = [this, &pair, lets](const Node& from, Bytes datagram) {
      if (lets && !lets(from, datagram)) return std::vector<Bytes>{};
      observer.on_datagram(datagram, {"127.0.0.1", 7400, pair.world.now});
      return one(std::move(datagram));
    };
  }
  ObservedMeeting meeting() const {
    const auto all = meetings_of(observer);
    EXPECT_EQ(all.size(), 1u);
    return all.empty() ? ObservedMeeting{} : all.front();
  }
  // Expects that they do not talk, for this reason. Returns the sentence.
  std::string reason(Rule rule) const {
    const auto found = meeting();
    EXPECT_EQ(found.state, MeetingState::apart);
    EXPECT_TRUE(found.finding && found.finding->rule == rule)
        << (found.finding ? found.finding->message : to_string(found.state));
    return found.finding ? found.finding->message : "";
  }
  std::vector<Rule> leaks() const {
    std::vector<Rule> out;
    for (const auto& finding : leaks_of(observer)) out.push_back(finding.rule);
    return out;
  }
  Observer observer;
};

TEST(Observer, Handshake_SaysWhoAuthenticatesAndHowLongItTook) {
  Pair pair(everything(ProtectionKind::encrypt));
  Listening listening(pair);
  ASSERT_TRUE(pair.match());
  pair.write();
  pair.world.run(5);
  const auto meeting = listening.meeting();
  EXPECT_EQ(meeting.state, MeetingState::authenticated);
  EXPECT_FALSE(meeting.finding);
  EXPECT_GT(meeting.took.value_or(0s), 0s);
  EXPECT_LT(meeting.took.value_or(0s), 1s);
  EXPECT_THAT(listening.leaks(), ::testing::IsEmpty());
  for (const auto& [prefix, participant] : listening.observer.participants()) {
    EXPECT_TRUE(participant.is_secured());
    EXPECT_EQ(participant.domain, 0);
    EXPECT_GT(participant.protected_messages, 0u);
    EXPECT_GT(participant.protected_submessages, 0u);
    EXPECT_TRUE(participant.kinds.contains(TransformKind{{0, 0, 0, 4}}));
    EXPECT_EQ(participant.clear_samples + participant.encrypted_payloads, 0u);
    EXPECT_TRUE(participant.clear_topics.empty());
    EXPECT_THAT(name_of(prefix, participant),
                ::testing::AnyOf(::testing::HasSubstr("CN=alice"), ::testing::HasSubstr("CN=bob")));
  }
}

TEST(Observer, LaterFastDdsBesideCycloneDds_IsReported) {
  Pair pair(everything(ProtectionKind::encrypt));
  auto vendors = std::array{kVendorFastDds, kVendorCyclone};
  Observer observer;
  pair.world.filter = [&](const Node& from, Bytes datagram) {
    auto seen = datagram;  // with another vendor, which is not authenticated
    const auto& vendor = vendors[&from == &pair.a ? 0 : 1];
    std::ranges::copy(vendor.octets, seen.begin() + 6);
    observer.on_datagram(seen, {"127.0.0.1", 7400, pair.world.now});
    return one(std::move(datagram));
  };
  ASSERT_TRUE(pair.match());
  pair.world.run(5);
  const auto of_two = [&] { return meetings_of(observer).at(0); };
  EXPECT_EQ(of_two().state, MeetingState::authenticated);
  ASSERT_TRUE(of_two().finding);
  EXPECT_EQ(of_two().finding->rule, Rule::CAP014);
  EXPECT_EQ(of_two().finding->severity, Severity::informational);
  vendors[1] = kVendorFastDds;
  pair.world.run(200);
  EXPECT_FALSE(of_two().finding);
}

TEST(Observer, DifferentGovernances_AreReportedWithTheirValues) {
  Pair pair(everything(ProtectionKind::encrypt), everything(ProtectionKind::sign));
  Listening listening(pair);
  pair.create_endpoints();
  pair.world.run(300);
  const auto reason = listening.reason(Rule::CAP004);
  EXPECT_THAT(reason, ::testing::HasSubstr("announces rtps ENCRYPT, discovery ENCRYPT"));
  EXPECT_THAT(reason, ::testing::HasSubstr("announces rtps SIGN, discovery SIGN"));
}

TEST(Observer, UnansweredRequest_IsReported) {
  Pair pair(everything(ProtectionKind::encrypt));
  Listening listening(
      pair, [](const Node&, const Bytes& datagram) { return !contains(datagram, "1.0+Reply"); });
  pair.create_endpoints();
  pair.world.run(100);
  EXPECT_EQ(listening.meeting().state, MeetingState::under_way) << "too early to judge";
  pair.world.run(300);
  EXPECT_THAT(listening.reason(Rule::CAP010), ::testing::HasSubstr("does not reply"));
}

TEST(Observer, ReplyThatIsNotAccepted_IsReported) {
  Pair pair(everything(ProtectionKind::encrypt));
  Listening listening(
      pair, [](const Node&, const Bytes& datagram) { return !contains(datagram, "1.0+Final"); });
  pair.create_endpoints();
  pair.world.run(400);
  EXPECT_THAT(listening.reason(Rule::CAP011), ::testing::HasSubstr("sends no final"));
}

TEST(Observer, PeerThatSendsNoKeys_IsNamed) {
  Pair pair(everything(ProtectionKind::encrypt));
  bool done = false;
  Listening listening(pair, [&](const Node& from, const Bytes& datagram) {
    done = done || contains(datagram, "1.0+Final");
    return !done || &from != &pair.b || contains(datagram, "dds.sec.auth");
  });
  pair.create_endpoints();
  pair.world.run(600);
  EXPECT_THAT(listening.reason(Rule::CAP012),
              ::testing::HasSubstr("and /O=Example/CN=bob sends no keys"));
}

TEST(Observer, HandshakeThatNeitherBegins_IsReported) {
  Pair pair(everything(ProtectionKind::encrypt));
  Listening listening(pair);
  pair.world.filter = [&](const Node&, const Bytes& datagram) {
    listening.observer.on_datagram(datagram, {"127.0.0.1", 7400, pair.world.now});
    return std::vector<Bytes>{};
  };
  pair.create_endpoints();
  pair.world.run(400);
  EXPECT_THAT(listening.reason(Rule::CAP013), ::testing::HasSubstr("neither sends"));
}

TEST(Observer, ParticipantWithoutSecurity_IsNamed) {
  Pair pair(everything(ProtectionKind::encrypt));
  Node plain(2);
  pair.world.nodes = {&pair.a, &plain};
  Listening listening(pair);
  pair.world.run(300);
  EXPECT_THAT(listening.reason(Rule::CAP001), ::testing::HasSubstr("announces no identity"));
}

TEST(Observer, WhatEveryListenerCanRead_IsReported) {
  Pair open(Rules{});
  Listening hears_all(open);
  ASSERT_TRUE(open.match());
  open.write();
  open.world.run(5);
  EXPECT_THAT(hears_all.leaks(),
              ::testing::UnorderedElementsAre(Rule::CAP020, Rule::CAP020, Rule::CAP021));
  Pair closed(Rules{.data = ProtectionKind::encrypt});
  Listening hears_topics(closed);
  ASSERT_TRUE(closed.match());
  closed.write();
  closed.world.run(5);
  EXPECT_THAT(hears_topics.leaks(), ::testing::Each(Rule::CAP020));
  std::uint64_t encrypted = 0;
  for (const auto& [prefix, participant] : hears_topics.observer.participants()) {
    encrypted += participant.encrypted_payloads;
    EXPECT_TRUE(participant.clear_topics.contains("Square"));
  }
  EXPECT_GT(encrypted, 0u);
}

// Returns an announcement that anyone could send.
Bytes announcement(const ParticipantData& data) {
  std::array<std::uint8_t, 4096> payload_octets, octets;
  SpanWriter payload(payload_octets), out(octets);
  write_payload(payload, data);
  write(out, Header{.prefix = data.guid.prefix});
  write(out, Data{.reader = kSpdpReader,
                  .writer = kSpdpWriter,
                  .kind = PayloadKind::data,
                  .payload = payload.view()});
  return to_bytes(out.view());
}

ParticipantData claims(std::uint8_t n, const std::string& identity_ca,
                       const std::string& permissions_ca) {
  ParticipantData data;
  data.guid = {GuidPrefix::from(Bytes(12, n)), kEntityIdParticipant};
  data.builtin_endpoints = builtin_endpoints::kWithSecurity;
  data.identity_token = spi::Token{"DDS:Auth:PKI-DH:1.0", {{"dds.ca.sn", identity_ca}}};
  data.permissions_token =
      spi::Token{"DDS:Access:Permissions:1.0", {{"dds.perm_ca.sn", permissions_ca}}};
  data.security_info = spi::security_info(spi::ParticipantSecurityAttributes{});
  return data;
}

// Returns the finding about two participants that only announce themselves.
std::optional<Rule> rule_of(const ParticipantData& a, const ParticipantData& b,
                            std::uint16_t port_of_b = 7400) {
  Observer observer;
  observer.on_datagram(announcement(a), {"10.0.0.1", 7400, 1s});
  observer.on_datagram(announcement(b), {"10.0.0.2", port_of_b, 2s});
  const auto all = meetings_of(observer);
  return all.empty() || !all.front().finding ? std::nullopt
                                             : std::optional(all.front().finding->rule);
}

TEST(Observer, IssuersAndSigners_AreCompared) {
  const auto a = claims(1, "CN=Identity CA,O=Example", "CN=Permissions CA");
  EXPECT_EQ(rule_of(a, claims(2, "CN=Other CA,O=Example", "CN=Permissions CA")), Rule::CAP002);
  EXPECT_EQ(rule_of(a, claims(2, "/O=Example/CN=Identity CA", "CN=Other CA")), Rule::CAP003);
  EXPECT_EQ(rule_of(a, claims(2, "O = x, CN=Identity CA", "CN=Permissions CA")), Rule::CAP002);
  EXPECT_EQ(rule_of(a, claims(2, "/O=Example/CN=Identity CA", "/CN=Permissions CA")), std::nullopt);
}

TEST(Observer, AName_IsOneLine) {
  auto data = claims(1, "CN=CA", "");
  data.identity_token->properties.push_back({"dds.cert.sn", "CN=a\nerror[x]: \033[31mforged"});
  Observer observer;
  observer.on_datagram(announcement(data), {"10.0.0.1", 7400, 1s});
  const auto& [prefix, participant] = *observer.participants().begin();
  EXPECT_EQ(name_of(prefix, participant), "CN=a?error[x]: ?[31mforged");
}

TEST(Observer, NameWithEscapes_IsReadable) {
  const auto name = [](std::string subject) {
    ObservedParticipant participant;
    participant.certificate = CertificateNames{std::move(subject), ""};
    return name_of({}, participant);
  };
  EXPECT_EQ(name(R"(CN=M\C3\BCller,O=a\,b)"), "CN=Müller,O=a,b");
  EXPECT_EQ(name(R"(/CN=M\xC3\xBCller)"), "/CN=Müller");
  EXPECT_EQ(name(R"(/CN=\/demo\/talker/O=a\+b)"), "/CN=/demo/talker/O=a+b");
  EXPECT_EQ(name(R"(CN=a\,O=b\/CN=c\+d=e)"), R"(CN=a\,O=b\/CN=c\+d=e)")
      << "it would look like another";
  EXPECT_EQ(name(R"(CN=a\1B[31m\0A\2C)"), R"(CN=a\1B[31m\0A\2C)") << "no letter";
  EXPECT_EQ(name(R"(CN=\\C3\\BC\)"), R"(CN=\\C3\\BC\)") << "the backslash is escaped";
  EXPECT_EQ(name(R"(CN=\C3)"), R"(CN=\xc3)") << "no UTF-8";
  EXPECT_EQ(name(R"(CN=\E2\80\AEa)"), R"(CN=\u202ea)") << "it would change the direction";
}

// In the message of a relay, what follows INFO_SRC is from another participant (RTPS 8.3.8.9.4).
TEST(Observer, MessageOfARelay_SpeaksForItsSource) {
  const auto data = claims(1, "CN=CA", "");
  std::array<std::uint8_t, 64> head_octets;
  SpanWriter head(head_octets);
  write(head, Header{.prefix = GuidPrefix::from(Bytes(12, 9))});
  write(head, InfoSource{Header{.prefix = data.guid.prefix}});
  auto message = to_bytes(head.view());
  const auto said = announcement(data);
  message.insert(message.end(), said.begin() + kHeaderSize, said.end());
  Observer observer;
  observer.on_datagram(message, {"10.0.0.1", 7400, 1s});
  ASSERT_EQ(observer.participants().size(), 2u);
  EXPECT_TRUE(observer.participants().at(data.guid.prefix).data);
  EXPECT_FALSE(observer.participants().at(GuidPrefix::from(Bytes(12, 9))).data);
}

TEST(Observer, OtherDomains_DoNotMeet) {
  const auto a = claims(1, "CN=Identity CA", ""), b = claims(2, "CN=Other CA", "");
  EXPECT_EQ(rule_of(a, b), Rule::CAP002);
  EXPECT_EQ(rule_of(a, b, 7650), std::nullopt);
}

TEST(Observer, ManyInventedParticipants_AreBounded) {
  Observer observer;
  for (std::uint32_t i = 0; i < 5000; ++i) {
    auto data = claims(1, "CN=CA", "");
    data.guid.prefix.octets[0] = static_cast<std::uint8_t>(i);
    data.guid.prefix.octets[1] = static_cast<std::uint8_t>(i >> 8);
    observer.on_datagram(announcement(data), {"10.0.0.1", 7400, 1s});
  }
  EXPECT_EQ(observer.participants().size(), Observer::kMaxParticipants);
  EXPECT_EQ(observer.left_out(), 5000 - Observer::kMaxParticipants);
  EXPECT_EQ(meetings_of(observer).size(), kMaxMeetings);
}

TEST(Observer, AnnouncementsCutAtEachOctet_AreNotTaken) {
  const auto whole = announcement(claims(1, "CN=Identity CA", "CN=Permissions CA"));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    Observer observer;
    observer.on_datagram(BytesView(whole).first(size), {"10.0.0.1", 7400, 1s});
    EXPECT_EQ(observer.rtps_messages(), size >= kHeaderSize ? 1u : 0u);
    EXPECT_EQ(meetings_of(observer).size(), 0u);
    for (const auto& [prefix, participant] : observer.participants())
      EXPECT_FALSE(participant.data) << size;
  }
}

// Returns one announcement of SEDP, in the clear.
Bytes clear_topic(const GuidPrefix& from, std::uint32_t number) {
  EndpointData data;
  data.guid = {from, {{0, 0, 1, 3}}};
  data.topic_name = "topic " + std::to_string(number);
  data.type_name = std::string(200, 'T');
  Bytes buffer(4096), message(8192);
  SpanWriter payload(buffer), out(message);
  write_payload(payload, data);
  Header header;
  header.prefix = from;
  write(out, header);
  write(out,
        Data{kPublicationsReader, kPublicationsWriter, {1}, {}, PayloadKind::data, payload.view()});
  return to_bytes(out.view());
}

// Without the bound, 1,024 participants with 4,096 topics each took 2.6 GB.
TEST(Observer, TopicsOfStrangers_TakeFewOctetsAndNoPlaceFromOthers) {
  Observer observer;
  const auto say = [&](const GuidPrefix& who, std::uint32_t number) {
    observer.on_datagram(clear_topic(who, number), {"192.0.2.66", 7400, 1s});
  };
  std::size_t octets = 0;
  for (std::uint8_t stranger = 1; stranger <= 40; ++stranger)
    for (std::uint32_t number = 0; number < 4'000; ++number)
      say(GuidPrefix::from(Bytes(12, stranger)), number);
  const auto honest = GuidPrefix::from(Bytes(12, 200));
  for (std::uint32_t number = 0; number < 50; ++number) say(honest, number);
  for (const auto& [prefix, participant] : observer.participants())
    octets += participant.topic_octets;
  EXPECT_LE(octets, Observer::kMaxTopicOctets + 41 * Observer::kTopicOctetsOfEach);
  EXPECT_EQ(observer.participants().at(honest).clear_topics.size(), 50u);
  EXPECT_GT(observer.left_out(), 0u);
}

}  // namespace
}  // namespace ddssec::rtps
