// A participant without any right to a topic sends key messages in another participant's name, with
// keys that it was given.
#include "tests/unit/cryptography/insider.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "tests/unit/rtps_security/key_thief.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using cryptography::KeyMaterial;
using cryptography::testing::Insider;

constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kSignOa = ProtectionKind::sign_with_origin_authentication;
constexpr auto kEncryptOa = ProtectionKind::encrypt_with_origin_authentication;

KeyMaterial made_up(ProtectionKind kind, std::uint8_t number) {
  const bool encrypts = spi::is_encrypted(kind);
  KeyMaterial out{.kind = encrypts ? cryptography::kAes256Gcm : cryptography::kAes256Gmac};
  out.salt = cryptography::MasterSalt::copy_of(Bytes(32, 1)).value();
  out.sender_key_id = KeyId{{7, 7, 7, number}};
  out.sender_key = cryptography::MasterKey::copy_of(Bytes(32, number)).value();
  if (!spi::is_origin_authenticated(kind)) return out;
  out.receiver_key_id = KeyId{{8, 8, 8, number}};
  out.receiver_key = cryptography::MasterReceiverKey::copy_of(Bytes(32, 3)).value();
  return out;
}

// Alice writes and bob reads. Mallory may use another topic only, and keeps all keys that it gets.
struct Outsider {
  explicit Outsider(const Rules& rules) : Outsider(rules, KeyThief::into(stolen)) {}
  Outsider(const Rules& rules, const Node::Wrap& wrap)
      : rules(rules),
        alice(1, properties_of("CN=alice,O=Example", rules), 4),
        bob(2, properties_of("CN=bob,O=Example", rules), 4),
        mallory(3, properties_of("CN=mallory,O=Example", rules, {"Other"}), 4, wrap) {
    world.nodes = {&alice, &bob, &mallory};
    EXPECT_TRUE(world.run_until([&] {
      return alice.knows(mallory) && bob.knows(mallory) && alice.knows(bob) && bob.knows(alice);
    }));
    world.run(200);
  }

  bool match() {
    auto qos = default_reader_qos();
    qos.reliability.kind = ReliabilityKind::reliable;
    writer = alice->create_writer(square(default_writer_qos()), alice.listener, world.now).value();
    reader = bob->create_reader(square(qos), bob.listener, world.now).value();
    return world.run_until([&] { return bob.listener.matched == 1; }, 3000);
  }
  void write() {
    Change change;
    change.payload = payload();
    alice->local_endpoints().writer(writer)->write(std::move(change), world.now);
    world.run(100);
  }

  // Sends to bob each of the submessages in alice's name, with each of the keys.
  template <class Submessage>
  void forge(const std::vector<Submessage>& all) {
    std::uint32_t session = 0x40000000;
    EXPECT_FALSE(stolen.all.empty());
    for (const auto& token : stolen.all) {
      auto material = cryptography::read_crypto_token(token);
      if (!material || material->is_none()) continue;
      std::vector<KeyId> receivers;
      if (material->has_receiver_key()) receivers.push_back(material->receiver_key_id);
      Insider insider(std::move(*material), {session++, 6});
      for (const auto& one : all) {
        const auto whole = forged({}, one);
        const Bytes content(whole.begin() + kHeaderSize, whole.end());
        auto datagram = forged(alice->prefix(), InfoDestination{bob->prefix()});
        const auto group = insider.group(cryptography::kSubmessageFrame, content, receivers);
        datagram.insert(datagram.end(), group.begin(), group.end());
        bob->receive(datagram, world.now);
      }
    }
    world.run(50);
  }

  Bytes key_message(std::string_view message_class, std::vector<spi::Token> tokens) {
    GenericMessage out;
    out.identity = {{alice->prefix(), kVolatileMessageWriter}, 77};
    out.destination_participant = {bob->prefix(), kEntityIdParticipant};
    if (message_class != message_class::kParticipantTokens) {
      out.destination_endpoint = reader;
      out.source_endpoint = writer;
    }
    out.message_class = message_class;
    out.data = std::move(tokens);
    return write_generic_message(out);
  }

  Rules rules;
  KeyThief::Stolen stolen;
  Node alice, bob, mallory;
  World world;
  Guid writer, reader;
};

std::vector<Rules> all_rules() {
  return {
      {.rtps = kSign,
       .discovery = kEncrypt,
       .liveliness = kEncrypt,
       .metadata = kEncrypt,
       .data = kEncrypt},
      {.discovery = kEncrypt, .metadata = kEncrypt},
      {.discovery = kEncrypt, .metadata = kEncryptOa},
      {.rtps = kSignOa, .discovery = kEncrypt},
      {.rtps = kSignOa, .discovery = kSign, .metadata = kEncryptOa},
      {.liveliness = kSign, .metadata = kEncryptOa},
  };
}

TEST(VolatileKeys, TokensUnderAnotherKeyOfThePeer_ReplaceNone) {
  for (const auto& rules : all_rules()) {
    Outsider all(rules);
    ASSERT_TRUE(all.match());
    std::vector<spi::Token> tokens;
    if (is_protected(rules.metadata)) tokens.push_back(crypto_token(made_up(rules.metadata, 1)));
    if (is_protected(rules.data)) tokens.push_back(crypto_token(made_up(rules.data, 2)));
    std::vector<Bytes> messages;
    if (!tokens.empty())
      messages.push_back(all.key_message(message_class::kDatawriterTokens, tokens));
    if (is_protected(rules.rtps))
      messages.push_back(all.key_message(message_class::kParticipantTokens,
                                         {crypto_token(made_up(rules.rtps, 4))}));
    std::vector<Data> forgeries;  // several, because the next number of alice's writer is not known
    for (std::int64_t number = 1; number < 40; ++number)
      for (const auto& message : messages)
        forgeries.push_back({kVolatileMessageReader,
                             kVolatileMessageWriter,
                             {number},
                             {},
                             PayloadKind::data,
                             message});
    all.forge(forgeries);
    for (int i = 0; i < 10; ++i) all.write();
    EXPECT_EQ(all.bob.listener.changes.size(), 10u) << all.bob.events.text();
    EXPECT_EQ(all.bob.listener.matched, 1);
  }
}

TEST(VolatileKeys, HeartbeatAndGapUnderAnotherKeyOfThePeer_HoldNoKeysUp) {
  for (const auto& rules : all_rules()) {
    Outsider all(rules);
    constexpr std::int64_t kFar = 1'000'000'000;
    all.forge(std::vector{Heartbeat{.reader = kVolatileMessageReader,
                                    .writer = kVolatileMessageWriter,
                                    .first = {kFar},
                                    .last = {kFar},
                                    .count = kFar}});
    all.forge(std::vector{Gap{.reader = kVolatileMessageReader,
                              .writer = kVolatileMessageWriter,
                              .start = {1},
                              .list = SequenceNumberSet{SequenceNumber{kFar}}}});
    EXPECT_TRUE(all.match()) << all.bob.events.text();
  }
}

// ---- requests for the tokens of others

struct Requests {
  std::size_t sent = 0;
  std::size_t answers = 0;     ///< messages of volatile writers
  std::size_t for_others = 0;  ///< those that name another destination
  std::optional<GuidPrefix> own = {};
};

// Does the same as the plugin behind it, but never acknowledges key tokens. Instead, it requests a
// fragment of each message of the volatile writer.
class Requester final : public spi::Cryptography, spi::CryptoTransform {
 public:
  Requester(std::unique_ptr<spi::Cryptography> plugin, Requests& requests)
      : plugin_(std::move(plugin)), requests_(requests) {}
  static Node::Wrap into(Requests& requests) {
    return [&requests](std::unique_ptr<spi::Cryptography> plugin) {
      return std::make_unique<Requester>(std::move(plugin), requests);
    };
  }
  spi::CryptoKeyFactory& key_factory() override { return plugin_->key_factory(); }
  spi::CryptoKeyExchange& key_exchange() override { return plugin_->key_exchange(); }
  spi::CryptoTransform& transform() override { return *this; }

 private:
  using Participant = spi::ParticipantCryptoHandle;
  using DataWriter = spi::DatawriterCryptoHandle;
  using DataReader = spi::DatareaderCryptoHandle;
  using Size = Result<std::size_t>;

  Size encode_serialized_payload(DataWriter sender, BytesView plain, MutableBytes out) override {
    return plugin().encode_serialized_payload(sender, plain, out);
  }
  Size encode_datawriter_submessage(DataWriter sender, std::span<const DataReader> receivers,
                                    BytesView plain, MutableBytes out) override {
    return plugin().encode_datawriter_submessage(sender, receivers, plain, out);
  }
  Size encode_datareader_submessage(DataReader sender, std::span<const DataWriter> receivers,
                                    BytesView plain, MutableBytes out) override {
    constexpr std::uint8_t kAckNack = 0x06;
    const bool acknowledges =
        plain[0] == kAckNack && EntityId::from(plain.subspan(4)) == kVolatileMessageReader;
    return plugin().encode_datareader_submessage(sender, receivers,
                                                 acknowledges ? request() : plain, out);
  }
  Size encode_rtps_message(Participant sender, std::span<const Participant> receivers,
                           BytesView plain, MutableBytes out) override {
    return plugin().encode_rtps_message(sender, receivers, plain, out);
  }
  Size decode_rtps_message(Participant receiver, Participant sender, BytesView encoded,
                           MutableBytes out) override {
    return plugin().decode_rtps_message(receiver, sender, encoded, out);
  }
  Result<spi::SecureSubmessage> preprocess_secure_submessage(Participant receiver,
                                                             Participant sender,
                                                             BytesView encoded) override {
    return plugin().preprocess_secure_submessage(receiver, sender, encoded);
  }
  Size decode_datawriter_submessage(DataReader receiver, DataWriter sender, BytesView encoded,
                                    MutableBytes out) override {
    const auto size = plugin().decode_datawriter_submessage(receiver, sender, encoded, out);
    if (size) note(out.first(*size));
    return size;
  }
  Size decode_datareader_submessage(DataWriter receiver, DataReader sender, BytesView encoded,
                                    MutableBytes out) override {
    return plugin().decode_datareader_submessage(receiver, sender, encoded, out);
  }
  Size decode_serialized_payload(DataReader receiver, DataWriter sender, BytesView encoded,
                                 MutableBytes out) override {
    return plugin().decode_serialized_payload(receiver, sender, encoded, out);
  }

  spi::CryptoTransform& plugin() { return plugin_->transform(); }

  // Returns a NACK_FRAG of the volatile reader, for another message each time.
  BytesView request() {
    constexpr std::size_t kMessages = 40;
    FragmentNumberSet missing(FragmentNumber{1});
    missing.insert(FragmentNumber{1});
    const NackFrag nack{kVolatileMessageReader,
                        kVolatileMessageWriter,
                        {static_cast<std::int64_t>(requests_.sent % kMessages + 1)},
                        missing,
                        static_cast<std::int32_t>(++requests_.sent)};
    const auto whole = forged({}, nack);
    request_.assign(whole.begin() + kHeaderSize, whole.end());
    return request_;
  }
  void note(BytesView plain) {
    constexpr std::uint8_t kData = 0x15;
    constexpr std::size_t kDestinationAt = 24 + 52;
    if (plain[0] != kData || EntityId::from(plain.subspan(12)) != kVolatileMessageWriter) return;
    ++requests_.answers;
    const auto to = GuidPrefix::from(plain.subspan(kDestinationAt, GuidPrefix::size));
    if (to != requests_.own.value_or(to)) ++requests_.for_others;
    requests_.own = requests_.own.value_or(to);  // the first one comes before any request
  }

  std::unique_ptr<spi::Cryptography> plugin_;
  Requests& requests_;
  Bytes request_;
};

// Alice has one volatile writer for each peer, so no request reaches the tokens for another peer.
TEST(VolatileKeys, RequestedByNackFrag_AreThoseForThePeerAlone) {
  Requests requests;
  const Rules rules{.rtps = kSign,
                    .discovery = kEncrypt,
                    .liveliness = kEncrypt,
                    .metadata = kEncryptOa,
                    .data = kEncrypt};
  Outsider all(rules, Requester::into(requests));
  ASSERT_TRUE(all.match()) << all.alice.events.text();
  all.world.run(1000);
  for (int i = 0; i < 10; ++i) all.write();
  EXPECT_EQ(all.bob.listener.changes.size(), 10u) << all.bob.events.text();
  EXPECT_GT(requests.sent, 10u);
  EXPECT_GT(requests.answers, 0u);
  EXPECT_EQ(requests.own, all.mallory->prefix());
  EXPECT_EQ(requests.for_others, 0u);
  EXPECT_TRUE(all.alice.events.has(Code::token_fragment_not_sent)) << all.alice.events.text();
}

}  // namespace
}  // namespace ddssec::rtps
