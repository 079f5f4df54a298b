// What the authentication tests share: identities, plugins, pairs of participants that shake hands,
// and a peer whose tokens the test builds in the style of another vendor.
#pragma once

#include <algorithm>
#include <chrono>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "base/documents_in_use.hpp"
#include "base/event.hpp"
#include "base/writer.hpp"
#include "pki/authority.hpp"
#include "pki/key_agreement.hpp"
#include "pki/signature.hpp"
#include "plugins/authentication/adjusted_guid.hpp"
#include "plugins/authentication/authentication.hpp"
#include "plugins/spi/property_names.hpp"
#include "tests/support/expect_code.hpp"
#include "tests/support/recorded_events.hpp"
#include "tests/support/seeded_random.hpp"
#include "tests/support/test_ca.hpp"

namespace ddssec::authentication {

using namespace std::chrono_literals;
using pki::KeyKind;
using pki::KeySpec;
using spi::Challenge;
using spi::HandshakeHandle;
using spi::IdentityHandle;
using spi::PropertyList;
using spi::Token;
using spi::ValidationResult;

using test::kNow;
using test::kYear;
using test::test_random;

/// Returns a key of this kind and index, which is made once in a process, because RSA keys take
/// long to make.
inline const pki::PrivateKey& key_of(KeySpec spec, int index = 0) {
  static std::map<std::tuple<KeyKind, int, int>, pki::PrivateKey> keys;
  const std::tuple id{spec.kind, spec.bits, index};
  if (const auto known = keys.find(id); known != keys.end()) return known->second;
  return keys.emplace(id, pki::PrivateKey::generate(spec.kind, spec.bits).value()).first->second;
}

inline pki::Authority make_ca(std::string_view subject = "CN=Identity CA,O=Example",
                              KeySpec key = {}, pki::Validity validity = kYear) {
  return test::make_ca(subject, key, validity);
}

/// Returns the CA of tests for which any CA will do.
inline const pki::Authority& test_ca() {
  static const pki::Authority ca = make_ca();
  return ca;
}

struct Identity {
  pki::Certificate certificate;
  pki::PrivateKey key;
  PropertyList properties;
};

inline std::string pem_text(const pki::PrivateKey& key) {
  return key.to_pem().value().expose([](BytesView pem) { return std::string(as_text(pem)); });
}

inline void set(PropertyList& properties, std::string_view name, std::string value) {
  std::erase_if(properties, [&](const auto& p) { return p.name == name; });
  properties.push_back({std::string(name), std::move(value), false});
}

inline Identity identity_of(pki::Certificate certificate, pki::PrivateKey key,
                            const std::string& ca_pem) {
  PropertyList properties;
  set(properties, spi::property::kIdentityCa, "data:," + ca_pem);
  set(properties, spi::property::kIdentityCertificate, "data:," + certificate.pem());
  set(properties, spi::property::kPrivateKey, "data:," + pem_text(key));
  return {std::move(certificate), std::move(key), std::move(properties)};
}

inline Identity make_identity(const pki::Authority& ca, std::string subject, KeySpec spec = {},
                              pki::Validity validity = kYear, int key_index = 0) {
  const auto& key = key_of(spec, key_index);
  auto certificate =
      ca.certify({.subject = std::move(subject), .validity = validity}, key, test_random()).value();
  return identity_of(std::move(certificate), key, ca.certificate().pem());
}

/// One process: a plugin with its clock.
struct TestPlugin {
  explicit TestPlugin(std::uint64_t seed = 1, AuthenticationOptions options = {})
      : random(seed), plugin(make_authentication({clock, random, events, &documents}, options)) {}
  spi::Authentication* operator->() { return plugin.get(); }
  /// As a host does every few seconds. Returns which identities have ended.
  std::vector<spi::IdentityHandle> poll(std::chrono::seconds after = std::chrono::seconds(5)) {
    clock.advance(after);
    return plugin->poll();
  }
  /// As often as a host would in a quarter of a minute. Returns the events of that time; `ended`
  /// has the identities that ended in it.
  std::vector<Code> codes_after_looking() {
    events.all.clear();
    ended.clear();
    for (int i = 0; i < 3; ++i)
      for (const auto handle : poll()) ended.push_back(handle);
    return events.codes();
  }

  ManualClock clock{kNow};
  SeededRandom random;
  test::RecordedEvents events;
  DocumentsInUse documents;
  std::unique_ptr<spi::Authentication> plugin;
  std::vector<spi::IdentityHandle> ended;
};

inline Guid candidate(std::uint8_t number) {
  Guid guid{{}, kEntityIdParticipant};
  guid.prefix.octets.fill(number);
  return guid;
}

using VendorId = std::array<std::uint8_t, 2>;
inline constexpr VendorId kCycloneDds{1, 16}, kFastDds{1, 15};

/// Returns ParticipantBuiltinTopicData as a big-endian parameter list, with the IdentityToken in it
/// if there is one.
inline Bytes participant_data(const Guid& guid, const Token* identity_token = nullptr,
                              const VendorId& vendor = kCycloneDds) {
  Writer writer(Endian::big);
  const auto parameter = [&](std::uint16_t id, BytesView value) {
    writer.write(id);
    writer.write(static_cast<std::uint16_t>(value.size()));
    writer.write_bytes(value);
  };
  parameter(0x0015, Bytes{2, 3, 0, 0});
  parameter(0x0016, Bytes{vendor[0], vendor[1], 0, 0});
  parameter(0x1005, Bytes(12));  // the 1.2 form of PARTICIPANT_SECURITY_INFO
  parameter(0x0050, guid.octets());
  if (identity_token != nullptr) {
    Writer token(Endian::big);
    spi::write_token(token, *identity_token);
    parameter(0x1001, token.take());
  }
  parameter(0x4014, Bytes{0, 0, 0, 1, 0, 0, 0, 0});  // unknown, must-understand bit set
  writer.write(std::uint16_t{1});
  writer.write(std::uint16_t{0});
  return writer.take();
}

/// Returns a field of a token.
inline const Bytes& field(const Token& token, std::string_view name) {
  const Bytes* value = spi::find_binary_property(token, name);
  static const Bytes kNone;
  EXPECT_NE(value, nullptr) << name;
  return value == nullptr ? kNone : *value;
}
inline Token with(Token token, std::string_view name, Bytes value) {
  const auto found = std::ranges::find(token.binary_properties, name, &spi::BinaryProperty::name);
  if (found == token.binary_properties.end())
    token.binary_properties.push_back({std::string(name), std::move(value)});
  else
    found->value = std::move(value);
  return token;
}
inline Token without(Token token, std::string_view name) {
  std::erase_if(token.binary_properties, [&](const auto& p) { return p.name == name; });
  return token;
}
/// Returns a request that an attacker can send after it has seen an honest one.
inline Token forged(const Token& request, std::uint8_t number) {
  return without(with(request, "challenge1", Bytes(32, number)), "hash_c1");
}
/// Returns an AuthRequestMessageToken.
inline Token sample() {
  return {.class_id = "DDS:Auth:PKI-DH:1.0+AuthReq",
          .binary_properties = {{"future_challenge", Bytes(32)}}};
}
inline Bytes flipped(Bytes octets, std::size_t at) {
  octets.at(at) ^= 1;
  return octets;
}
inline Bytes bytes(std::string_view text) { return to_bytes(as_bytes(text)); }

/// A participant in a plugin of its own or a shared one.
struct Participant {
  Participant(TestPlugin& where, const Identity& identity, std::uint8_t number = 1,
              spi::CipherMask ciphers = spi::kStandardCiphers)
      : plugin(&where) {
    const auto local = where->validate_local_identity(0, identity.properties, candidate(number));
    EXPECT_TRUE(local) << local.error().to_sentence();
    if (!local) return;
    handle = local->handle;
    guid = local->adjusted_guid;
    token = where->identity_token(handle, ciphers).value();
    data = participant_data(guid, &token);
  }
  Result<spi::Authentication::RemoteIdentity> discover(const Participant& other,
                                                       std::optional<Token> auth_request = {}) {
    return (*plugin)->validate_remote_identity(handle, auth_request, other.token, other.guid);
  }

  TestPlugin* plugin;
  IdentityHandle handle;
  Guid guid;
  Token token;
  Bytes data;
};

/// Two participants that know of each other. The handshake begins at `low`.
struct Two {
  Two(Participant& a, Participant& b)
      : low(a.guid < b.guid ? a : b), high(a.guid < b.guid ? b : a) {
    const auto of_low = low.discover(high);
    const auto of_high = high.discover(low);
    EXPECT_TRUE(of_low && of_high);
    if (!of_low || !of_high) return;
    EXPECT_EQ(of_low->result, ValidationResult::pending_handshake_request);
    EXPECT_EQ(of_high->result, ValidationResult::pending_handshake_message);
    high_at_low = of_low->handle;
    low_at_high = of_high->handle;
  }
  using Step = Result<spi::Authentication::HandshakeStep>;
  Step request() {
    return (*low.plugin)->begin_handshake_request(low.handle, high_at_low, low.data);
  }
  Step reply(const Token& request) {
    return (*high.plugin)->begin_handshake_reply(request, low_at_high, high.handle, high.data);
  }
  Step process_at_lower_guid(HandshakeHandle handle, const Token& message) {
    return (*low.plugin)->process_handshake(handle, message);
  }
  Step process_at_higher_guid(HandshakeHandle handle, const Token& message) {
    return (*high.plugin)->process_handshake(handle, message);
  }

  Participant& low;
  Participant& high;
  IdentityHandle high_at_low;
  IdentityHandle low_at_high;
};

/// Two participants in two plugins under one CA, and the messages of an honest handshake.
struct Pairing {
  explicit Pairing(const Identity& first = make_identity(test_ca(), "CN=alice,O=Example"),
                   const Identity& second = make_identity(test_ca(), "CN=bob,O=Example", {}, kYear,
                                                          1))
      : a(first_plugin, first, 1), b(second_plugin, second, 2), two(a, b) {}

  /// Returns true if the two authenticate each other.
  static bool authenticate(Two& two) {
    const auto request = two.request();
    const auto reply = request ? two.reply(*request->message) : request;
    const auto final_message =
        reply ? two.process_at_lower_guid(request->handle, *reply->message) : reply;
    const auto end = final_message
                         ? two.process_at_higher_guid(reply->handle, *final_message->message)
                         : final_message;
    return end && end->result == ValidationResult::ok;
  }
  void expect_success() { expect_success_of(two); }
  static void expect_success_of(Two& two) {
    const auto request = two.request();
    ASSERT_OK(request);
    EXPECT_EQ(request->result, ValidationResult::pending_handshake_message);
    const auto reply = two.reply(*request->message);
    ASSERT_OK(reply);
    EXPECT_EQ(reply->result, ValidationResult::pending_handshake_message);
    expect_finish_of(two, *request, *reply);
  }
  void expect_finish(const spi::Authentication::HandshakeStep& request,
                     const spi::Authentication::HandshakeStep& reply) {
    expect_finish_of(two, request, reply);
  }
  static void expect_finish_of(Two& two, const spi::Authentication::HandshakeStep& request,
                               const spi::Authentication::HandshakeStep& reply) {
    const auto final_message = two.process_at_lower_guid(request.handle, *reply.message);
    ASSERT_OK(final_message);
    EXPECT_EQ(final_message->result, ValidationResult::ok_final_message);
    const auto end = two.process_at_higher_guid(reply.handle, *final_message->message);
    ASSERT_OK(end);
    EXPECT_EQ(end->result, ValidationResult::ok);
    EXPECT_FALSE(end->message);
    const auto of_low = (*two.low.plugin)->shared_secret(request.handle);
    const auto of_high = (*two.high.plugin)->shared_secret(reply.handle);
    ASSERT_OK(of_low);
    ASSERT_OK(of_high);
    EXPECT_EQ((*of_low)->secret, (*of_high)->secret);
    EXPECT_EQ((*of_low)->secret.size(), 32u);
    EXPECT_EQ((*of_low)->challenge1, (*of_high)->challenge1);
    EXPECT_EQ((*of_low)->challenge2, (*of_high)->challenge2);
  }

  TestPlugin first_plugin{1};
  TestPlugin second_plugin{2};
  Participant a;
  Participant b;
  Two two;
};

/// How another vendor writes its tokens.
struct Style {
  bool optional_fields = true;
  bool nul_terminated = false;  // Cyclone DDS
  bool permissions = true;      // Fast DDS leaves c.perm out without access control
  bool reversed = false;        // another order of the fields that are not c.*
  std::string signature_name = "ECDSA-SHA256";
  std::string key_agreement_name = "ECDH+prime256v1-CEUM";
};

/// A peer that follows the text of the standard, without the plugin's own message code.
class HandMadePeer {
 public:
  HandMadePeer(Identity identity, std::uint8_t number, Style style = {})
      : identity_(std::move(identity)),
        style_(std::move(style)),
        guid_(adjusted_guid(identity_.certificate.subject_digest(), candidate(number))),
        data_(participant_data(guid_)) {
    challenge_.fill(number);
  }
  const Guid& guid() const { return guid_; }
  Token identity_token() const { return {std::string(spi::class_id::kIdentity)}; }

  Token request(pki::KeyAgreementKind kind, pki::PublicKeyEncoding encoding) {
    key_ = pki::EphemeralKey::generate(kind).value();
    encoding_ = encoding;
    Token token{"DDS:Auth:PKI-DH:1.0+Req"};
    add_credentials(token);
    hash_c1_ = hash(token);
    dh1_ = *key_->public_octets(encoding);
    challenge1_ = Bytes(challenge_.begin(), challenge_.end());
    add(token, {{"hash_c1", hash_c1_, true}, {"dh1", dh1_}, {"challenge1", challenge1_}});
    return token;
  }

  /// Checks the other side's reply as the standard demands it, and returns the final message.
  Token final(const Token& reply, const pki::Certificate& signer) {
    EXPECT_EQ(field(reply, "challenge1"), challenge1_);
    EXPECT_EQ(field(reply, "dh1"), dh1_);
    EXPECT_EQ(field(reply, "hash_c1"), hash_c1_);
    challenge2_ = field(reply, "challenge2");
    dh2_ = field(reply, "dh2");
    hash_c2_ = hash(reply);
    EXPECT_EQ(field(reply, "hash_c2"), hash_c2_);
    EXPECT_TRUE(pki::verify(signer, reply_input(), field(reply, "signature")));
    secret_ = key_->derive(dh2_).value();
    Token token{"DDS:Auth:PKI-DH:1.0+Final"};
    add(token, {{"challenge1", challenge1_},
                {"challenge2", challenge2_},
                {"dh1", dh1_, true},
                {"dh2", dh2_, true},
                {"hash_c2", hash_c2_, true},
                {"hash_c1", hash_c1_, true},
                {"signature", pki::sign(identity_.key, final_input()).value()}});
    return token;
  }

  Token reply(const Token& request) {
    key_ = pki::EphemeralKey::generate(pki::KeyAgreementKind::ecdh_p256).value();
    challenge1_ = field(request, "challenge1");
    dh1_ = field(request, "dh1");
    hash_c1_ = hash(request);
    secret_ = key_->derive(dh1_).value();
    Token token{"DDS:Auth:PKI-DH:1.0+Reply"};
    add_credentials(token);
    hash_c2_ = hash(token);
    dh2_ = *key_->public_octets(pki::PublicKeyEncoding::plain_integer);
    challenge2_ = Bytes(challenge_.begin(), challenge_.end());
    add(token, {{"dh2", dh2_},
                {"challenge1", challenge1_},
                {"challenge2", challenge2_},
                {"dh1", dh1_, true},
                {"hash_c2", hash_c2_, true},
                {"hash_c1", hash_c1_, true},
                {"signature", pki::sign(identity_.key, reply_input()).value()}});
    return token;
  }
  void check_final(const Token& final, const pki::Certificate& signer) const {
    EXPECT_EQ(field(final, "challenge1"), challenge1_);
    EXPECT_EQ(field(final, "challenge2"), challenge2_);
    EXPECT_TRUE(pki::verify(signer, final_input(), field(final, "signature")));
  }
  void expect_same_secret(const spi::SharedSecret& other) const {
    other.secret.expose([&](BytesView theirs) {
      secret_.expose([&](BytesView ours) { EXPECT_TRUE(std::ranges::equal(ours, theirs)); });
    });
    EXPECT_TRUE(std::ranges::equal(other.challenge1, challenge1_));
    EXPECT_TRUE(std::ranges::equal(other.challenge2, challenge2_));
  }

 private:
  struct Field {
    std::string name;
    Bytes value;
    bool optional = false;
  };
  void add(Token& token, std::vector<Field> fields) const {
    if (style_.reversed) std::ranges::reverse(fields);
    for (auto& f : fields)
      if (!f.optional || style_.optional_fields)
        token.binary_properties.push_back({f.name, std::move(f.value)});
  }
  Bytes text(std::string_view value) const {
    Bytes octets = bytes(value);
    if (style_.nul_terminated) octets.push_back(0);
    return octets;
  }
  void add_credentials(Token& token) const {
    token.binary_properties.push_back({"c.id", bytes(identity_.certificate.pem())});
    if (style_.permissions) token.binary_properties.push_back({"c.perm", text("signed document")});
    token.binary_properties.push_back({"c.pdata", data_});
    token.binary_properties.push_back({"c.dsign_algo", text(style_.signature_name)});
    token.binary_properties.push_back({"c.kagree_algo", text(style_.key_agreement_name)});
  }
  static Bytes hash(const Token& token) {
    std::vector<spi::NamedOctets> fields;
    for (const auto& p : token.binary_properties)
      if (p.name.starts_with("c.")) fields.push_back({p.name, p.value});
    const auto digest = sha256(spi::serialize_binary_properties(fields));
    return Bytes(digest.begin(), digest.end());
  }
  Bytes reply_input() const {
    const std::vector<spi::NamedOctets> fields = {
        {"hash_c2", hash_c2_}, {"challenge2", challenge2_},
        {"dh2", dh2_},         {"challenge1", challenge1_},
        {"dh1", dh1_},         {"hash_c1", hash_c1_}};
    return spi::serialize_binary_properties(fields);
  }
  Bytes final_input() const {
    const std::vector<spi::NamedOctets> fields = {
        {"hash_c1", hash_c1_}, {"challenge1", challenge1_},
        {"dh1", dh1_},         {"challenge2", challenge2_},
        {"dh2", dh2_},         {"hash_c2", hash_c2_}};
    return spi::serialize_binary_properties(fields);
  }

  Identity identity_;
  Style style_;
  Guid guid_;
  Bytes data_;
  Challenge challenge_{};
  std::optional<pki::EphemeralKey> key_;
  pki::PublicKeyEncoding encoding_{};
  Bytes hash_c1_, challenge1_, dh1_, hash_c2_, challenge2_, dh2_;
  pki::AgreedSecret secret_;
};

}  // namespace ddssec::authentication
