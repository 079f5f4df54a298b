// Every entry of kat-crypto.json that is about something that ddssec implements: derivations, key
// material, payloads, submessages, messages, key exchange.
#include <fstream>
#include <queue>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "plugins/cryptography/derivation.hpp"
#include "plugins/cryptography/pre_shared_key.hpp"
#include "plugins/spi/property_names.hpp"
#include "tests/support/test_data.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

using Json = nlohmann::json;

const Json& kat() {
  static const Json kFile = [] {
    const auto read = [](const char* name) {
      std::ifstream file(test::data_path(std::string("dds-security-crypto/") + name));
      return Json::parse(file);
    };
    auto all = read("kat-crypto.json");
    const auto ours = read("kat-chacha.json");
    for (const auto& [section, entries] : ours.items())
      for (const auto& entry : entries) all[section].push_back(entry);
    return all;
  }();
  return kFile;
}

// The vectors of a section. The test fails if the files do not have this many: a loop over nothing
// would pass.
const Json& section(const char* name, std::size_t count) {
  const auto& entries = kat()[name];
  EXPECT_EQ(entries.size(), count) << name;
  return entries;
}

// Those without a key for one receiver. A plugin chooses the ids of such keys itself, so the
// others can be decoded but not reproduced.
std::vector<Json> for_all_receivers(const char* name, std::size_t count, std::size_t expected) {
  std::vector<Json> out;
  for (const auto& entry : section(name, count))
    if (!entry["receiver_specific"].get<bool>()) out.push_back(entry);
  EXPECT_EQ(out.size(), expected) << name;
  return out;
}

Bytes hex(const Json& digits) { return from_hex(digits.get<std::string>()).value(); }
Bytes input(const char* name) { return hex(kat()["inputs"][name]); }

// Returns a salt or key of the size of the kind.
template <class Key>
Key key_input(const char* name, std::size_t size) {
  return Key::copy_of(BytesView(input(name)).first(size)).value();
}

TransformKind kind_of(const Json& entry) {
  return TransformKind{{0, 0, 0, entry["kind"].get<std::uint8_t>()}};
}

KeyMaterial material_of(const Json& entry, bool receiver_specific) {
  KeyMaterial material{.kind = kind_of(entry)};
  const auto size = traits_of(material.kind)->key_size();
  material.salt = key_input<MasterSalt>("master_salt32", size);
  material.sender_key_id = KeyId::from(input("sender_key_id"));
  material.sender_key = key_input<MasterKey>("master_sender_key32", size);
  if (receiver_specific) {
    material.receiver_key_id = KeyId::from(input("receiver_specific_key_id"));
    material.receiver_key = key_input<MasterReceiverKey>("master_receiver_specific_key32", size);
  }
  return material;
}

template <class Key>
std::string hex_of(const Key& key) {
  return key.expose([](BytesView octets) { return to_hex(octets); });
}

TEST(Kat, SessionKeys_AreReproduced) {
  const auto session = SessionId::from(input("session_id"));
  for (const auto& entry : section("session_keys", 6)) {
    const auto material = material_of(entry, true);
    EXPECT_EQ(hex_of(derive_session_key(material.sender_key, material.salt, session)),
              entry["session_key"].get<std::string>());
    EXPECT_EQ(hex_of(derive_session_receiver_key(material.receiver_key, material.salt, session)),
              entry["session_receiver_specific_key"].get<std::string>());
  }
}

TEST(Kat, KeyMaterial_IsReproducedAndParsed) {
  for (const auto& entry : section("keymat", 12)) {
    const auto octets = serialize_key_material(material_of(entry, entry["receiver_specific"]));
    EXPECT_EQ(to_hex(octets), entry["cdr"].get<std::string>());
    const auto parsed = parse_key_material(octets);
    ASSERT_TRUE(parsed);
    EXPECT_EQ(serialize_key_material(*parsed), octets);
  }
}

spi::SharedSecret shared_of(const Json& entry, const char* secret) {
  spi::SharedSecret shared;
  shared.secret = spi::SharedSecretOctets::copy_of(hex(entry[secret])).value();
  std::ranges::copy(hex(entry["challenge1"]), shared.challenge1.begin());
  std::ranges::copy(hex(entry["challenge2"]), shared.challenge2.begin());
  return shared;
}

TEST(Kat, KeyExchange_IsReproduced) {
  const auto expect = [](const Json& entry, const char* secret) {
    const auto material = derive_key_exchange_material(shared_of(entry, secret));
    EXPECT_EQ(hex_of(material.salt), entry["kx_master_salt"].get<std::string>());
    EXPECT_EQ(hex_of(material.sender_key), entry["kx_master_sender_key"].get<std::string>());
    EXPECT_EQ(material.kind, kAes256Gcm);
    EXPECT_TRUE(material.sender_key_id.is_zero());
  };
  expect(kat()["kx"], "shared_secret_sha256");
  expect(kat()["kx_cyclone_test_pattern"], "shared_secret");
  const auto material =
      derive_key_exchange_material(shared_of(kat()["kx"], "shared_secret_sha256"));
  EXPECT_EQ(hex_of(derive_session_key(material.sender_key, material.salt,
                                      SessionId::from(hex("01020304")))),
            kat()["kx"]["session_key_for_session_id_01020304"].get<std::string>());
}

// Returns the values with which the vectors were made, in the order in which the plugin asks.
struct ScriptedRandom final : Random {
  Status fill(MutableBytes out) override {
    if (script.empty() || script.front().size() != out.size()) return fail_here();
    std::ranges::copy(script.front(), out.begin());
    script.pop();
    return {};
  }
  static Status fail_here() { return fail(Code::random_failed); }

  template <class T>
  void number(T value) {
    Bytes octets(sizeof value);
    std::memcpy(octets.data(), &value, sizeof value);
    script.push(std::move(octets));
  }
  void key(std::size_t size) {
    script.push(to_bytes(BytesView(input("master_salt32")).first(size)));
    script.push(to_bytes(BytesView(input("master_sender_key32")).first(size)));
    start();
  }
  // The session id and the IV suffix are drawn together.
  void start(std::uint32_t session = 0x01020304, std::uint64_t suffix = 0xa0a1a2a3a4a5a6a7) {
    Bytes octets(sizeof session + sizeof suffix);
    std::memcpy(octets.data(), &session, sizeof session);
    std::memcpy(octets.data() + sizeof session, &suffix, sizeof suffix);
    script.push(std::move(octets));
  }
  std::queue<Bytes> script;
};

ProtectionKind protection(const Json& entry, bool origin = false) {
  const bool encrypts = entry["kind"].get<int>() % 2 == 0;
  if (origin)
    return encrypts ? ProtectionKind::encrypt_with_origin_authentication
                    : ProtectionKind::sign_with_origin_authentication;
  return encrypts ? ProtectionKind::encrypt : ProtectionKind::sign;
}

std::size_t key_octets(const Json& entry) { return entry["kind"].get<int>() <= 2 ? 16 : 32; }
// Returns the property for an endpoint or a participant.
PropertyList cipher_property(const Json& entry) {
  if (entry["kind"] > 4) return cipher(spi::kChaCha20Poly1305Name, true);
  return key_size(key_octets(entry) == 16 ? "128" : "256");
}

class KatTransform : public ::testing::TestWithParam<AeadChoice> {
 protected:
  static CryptographyOptions options() { return {.aead = GetParam()}; }
};

// A plugin whose first key is that of the vectors.
struct Scripted {
  explicit Scripted(const CryptographyOptions& options) : services{clock, random, events} {
    random.number<std::uint64_t>(0);
    random.number<std::uint32_t>(0x0000c0de);
    plugin = make_cryptography(services, options);
  }
  SystemClock clock;
  ScriptedRandom random;
  test::RecordedEvents events;
  PluginServices services;
  std::unique_ptr<spi::Cryptography> plugin;
};

TEST_P(KatTransform, Payloads_Encode) {
  for (const auto& entry : section("payload", 12)) {
    Scripted side(options());
    auto& factory = side.plugin->key_factory();
    const auto participant = factory.register_local_participant({}, {}, {}, {}).value();
    side.random.key(key_octets(entry));
    const auto writer =
        factory
            .register_local_datawriter(participant, cipher_property(entry),
                                       endpoint_attributes(ProtectionKind::none, protection(entry)))
            .value();
    const auto plain = entry.contains("plain") ? hex(entry["plain"]) : input("plain_payload");
    const auto encoded = into_bytes(plain.size() + 44, [&](MutableBytes out) {
      return side.plugin->transform().encode_serialized_payload(writer, plain, out);
    });
    EXPECT_EQ(to_hex(*encoded), entry["encoded"].get<std::string>());
  }
}

TEST_P(KatTransform, Payloads_Decode) {
  for (const auto& entry : section("payload", 12)) {
    TwoSides two(ProtectionKind::none, {}, options());
    const auto e = two.endpoints(endpoint_attributes(ProtectionKind::none, protection(entry)));
    const auto token = crypto_token(material_of(entry, false));
    ASSERT_TRUE(two.take_writer(e, {&token, 1}));
    const auto plain = entry.contains("plain") ? hex(entry["plain"]) : input("plain_payload");
    EXPECT_EQ(to_hex(decode_payload(two, e, hex(entry["encoded"])).value()), to_hex(plain));
  }
}

TEST_P(KatTransform, Submessages_Encode) {
  for (const auto& entry : for_all_receivers("submessage", 12, 6)) {
    Scripted side(options());
    auto& factory = side.plugin->key_factory();
    const auto participant = factory.register_local_participant({}, {}, {}, {}).value();
    side.random.key(key_octets(entry));
    const auto writer =
        factory
            .register_local_datawriter(participant, cipher_property(entry),
                                       endpoint_attributes(protection(entry), ProtectionKind::none))
            .value();
    const auto plain = input("plain_data_submessage");
    const auto encoded = into_bytes(plain.size() + 112, [&](MutableBytes out) {
      return side.plugin->transform().encode_datawriter_submessage(writer, {}, plain, out);
    });
    EXPECT_EQ(to_hex(*encoded), entry["encoded"].get<std::string>());
  }
}

TEST_P(KatTransform, Submessages_Decode) {
  for (const auto& entry : section("submessage", 12)) {
    TwoSides two(ProtectionKind::none, {}, options());
    const bool origin = entry["receiver_specific"];
    const auto e =
        two.endpoints(endpoint_attributes(protection(entry, origin), ProtectionKind::none));
    const auto token = crypto_token(material_of(entry, origin));
    ASSERT_TRUE(two.take_writer(e, {&token, 1}));
    const auto encoded = hex(entry["encoded"]);
    const auto whose = two.b.transform().preprocess_secure_submessage({}, two.b.remote, encoded);
    EXPECT_EQ(whose.value().datawriter, e.remote_writer);
    EXPECT_EQ(to_hex(decode_submessage(two, e, encoded).value()),
              to_hex(input("plain_data_submessage")));
  }
}

TEST_P(KatTransform, Messages_Encode) {
  for (const auto& entry : for_all_receivers("rtps", 12, 6)) {
    Scripted side(options());
    side.random.key(key_octets(entry));
    const auto participant =
        side.plugin->key_factory()
            .register_local_participant({}, {}, cipher_property(entry),
                                        participant_attributes(protection(entry)))
            .value();
    const auto plain = input("plain_rtps_message");
    const auto encoded = into_bytes(plain.size() + 112, [&](MutableBytes out) {
      return side.plugin->transform().encode_rtps_message(participant, {}, plain, out);
    });
    EXPECT_EQ(to_hex(*encoded), entry["encoded"].get<std::string>());
  }
}

// The decoded message begins with INFO_SRC.
Bytes with_info_source(const Bytes& plain) {
  Bytes out(plain.begin(), plain.begin() + 20);
  for (const std::uint8_t octet : {0x0c, 0x01, 0x14, 0x00, 0, 0, 0, 0}) out.push_back(octet);
  out.insert(out.end(), plain.begin() + 4, plain.begin() + 20);
  out.insert(out.end(), plain.begin() + 20, plain.end());
  return out;
}

TEST_P(KatTransform, Messages_Decode) {
  for (const auto& entry : section("rtps", 12)) {
    const bool origin = entry["receiver_specific"];
    TwoSides two(protection(entry, origin), {}, options());
    const auto token = crypto_token(material_of(entry, origin));
    ASSERT_TRUE(two.take_participant({&token, 1}));
    EXPECT_EQ(to_hex(decode_message(two, hex(entry["encoded"])).value()),
              to_hex(with_info_source(input("plain_rtps_message"))));
  }
}

TEST_P(KatTransform, VolatileSubmessage_EncodesAndDecodes) {
  const auto& entry = kat()["kx"];
  const auto shared = shared_of(entry, "shared_secret_sha256");
  const auto matched = [&](Scripted& side) {
    auto& factory = side.plugin->key_factory();
    const auto participant = factory.register_local_participant({}, {}, {}, {}).value();
    return std::pair(
        participant,
        factory.register_matched_remote_participant(participant, {9}, {}, shared).value());
  };
  Scripted sender(options()), receiver(options());
  sender.random.start();
  receiver.random.start(0x05060708, 0);
  const auto [from, to_remote] = matched(sender);
  auto& at_sender = sender.plugin->key_factory();
  const auto writer =
      at_sender.register_local_datawriter(from, builtin_endpoint(kVolatileWriter), {}).value();
  const auto remote_reader =
      at_sender.register_matched_remote_datareader(writer, to_remote, shared, false).value();
  const auto plain = hex(entry["plain"]);
  const auto encoded = into_bytes(plain.size() + 112, [&](MutableBytes out) {
    return sender.plugin->transform().encode_datawriter_submessage(writer, {&remote_reader, 1},
                                                                   plain, out);
  });
  EXPECT_EQ(to_hex(*encoded), entry["volatile_secure_submessage"].get<std::string>());
  // There is one key for both directions.
  const auto [to, from_remote] = matched(receiver);
  auto& at_receiver = receiver.plugin->key_factory();
  const auto reader =
      at_receiver.register_local_datareader(to, builtin_endpoint(kVolatileReader), {}).value();
  const auto remote_writer =
      at_receiver.register_matched_remote_datawriter(reader, from_remote, shared).value();
  const auto decoded = into_bytes(encoded->size(), [&](MutableBytes out) {
    return receiver.plugin->transform().decode_datawriter_submessage(reader, remote_writer,
                                                                     *encoded, out);
  });
  ASSERT_TRUE(decoded);
  EXPECT_EQ(to_hex(*decoded), to_hex(plain));
}

Passphrase passphrase_of(const Json& entry) {
  return {entry["passphrase_id"].get<std::uint32_t>(),
          Passphrase::Text::copy_of(as_bytes(entry["passphrase"].get<std::string>())).value()};
}

// The example of DDS-Security 1.2, clause 10.5.2.1.3.
TEST(Kat, PreSharedKeyExample_IsReproduced) {
  const auto& entry = kat()["psk_spec_example"];
  const auto passphrase = passphrase_of(entry);
  const auto key_id = pre_shared_key_id(passphrase.id, entry["domain_id"].get<DomainId>(),
                                        entry["domain_tag"].get<std::string>());
  EXPECT_EQ(key_id.to_string(), entry["sender_key_id"].get<std::string>());
  const auto kind = pre_shared_kind(kAes256Gcm, passphrase.id);
  EXPECT_EQ(kind.to_string(), entry["key_revision"].get<std::string>() + "04");
  const auto header =
      hex(entry["protocol_version"].get<std::string>() + entry["vendor_id"].get<std::string>() +
          entry["guid_prefix"].get<std::string>());
  MessageSource source;
  std::ranges::copy(header, source.begin());
  const auto material = derive_pre_shared_material(passphrase, kind, key_id, source);
  EXPECT_EQ(hex_of(material.salt), entry["spec_master_salt"].get<std::string>());
  EXPECT_EQ(hex_of(material.sender_key), entry["spec_master_sender_key"].get<std::string>());
  const auto half =
      derive_pre_shared_material(passphrase, pre_shared_kind(kAes128Gcm, 0), key_id, source);
  EXPECT_EQ(hex_of(half.sender_key), hex_of(material.sender_key).substr(0, 32));
}

// ddssec does not send additional authenticated data (flag A).
TEST_P(KatTransform, PreSharedKeyMessages_Encode) {
  for (const auto& entry : section("psk_messages", 4)) {
    Scripted side(options());
    side.random.start();
    ParticipantSecurityAttributes attributes;
    attributes.rtps_psk = protection(entry);
    const PropertyList properties = {{std::string(spi::property::kPskPassphrase),
                                      "data:," + std::to_string(entry["passphrase_id"].get<int>()) +
                                          ":" + entry["passphrase"].get<std::string>()}};
    auto keys = side.plugin->key_factory()
                    .pre_shared_keys({properties, attributes, entry["domain_id"].get<DomainId>(),
                                      entry["domain_tag"].get<std::string>()})
                    .value();
    const auto plain = hex(entry["plain"]);
    const auto expected = hex(entry["encoded"]);
    const auto decoded =
        into_bytes(expected.size(), [&](MutableBytes out) { return keys->decode(expected, out); });
    if (entry["aad"].get<bool>()) {
      EXPECT_EQ(decoded.error().code(), Code::secure_flags_unsupported);
      continue;
    }
    EXPECT_EQ(to_hex(decoded.value()), to_hex(with_info_source(plain)));
    const auto encoded = into_bytes(plain.size() + spi::protection_overhead(0),
                                    [&](MutableBytes out) { return keys->encode(plain, out); });
    EXPECT_EQ(to_hex(encoded.value()), to_hex(expected));
  }
}

// The key revision and the flags of a pre-shared key are not those of a participant's key here.
TEST_P(KatTransform, ParticipantsKeys_RefusePreSharedKeyMessages) {
  TwoSides two(ProtectionKind::encrypt, {}, options());
  for (const auto& entry : section("psk_messages", 4))
    EXPECT_EQ(decode_message(two, hex(entry["encoded"])).error().code(),
              Code::secure_flags_unsupported);
}

INSTANTIATE_TEST_SUITE_P(Backends, KatTransform,
                         ::testing::Values(AeadChoice::automatic, AeadChoice::openssl),
                         [](const auto& info) {
                           return info.param == AeadChoice::automatic ? "automatic" : "openssl";
                         });

}  // namespace
}  // namespace ddssec::cryptography::testing
