#include "plugins/cyclonedds/cryptography_adapter.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <utility>

#include "plugins/cyclonedds/value_translation.hpp"
#include "plugins/spi/process_properties.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds {
namespace {

using testing::_;
using testing::ElementsAre;
using testing::Return;

struct CryptographyAdapterTest : testing::Test {
  Harness<CryptographyAdapter, MockCryptography, spi::Cryptography> harness;
  dds_security_crypto_key_factory* factory = harness.adapter.crypto_key_factory;
  dds_security_crypto_key_exchange* exchange = harness.adapter.crypto_key_exchange;
  dds_security_crypto_transform* transform = harness.adapter.crypto_transform;
  MockCryptography& engine = *harness.engine;
  Refusal refusal;

  Bytes secret_octets = Bytes(32, 9);
  SharedSecretLayout secret{secret_octets.data(), 32, {1}, {2}};
  DDS_Security_SharedSecretHandle secret_handle =
      reinterpret_cast<DDS_Security_SharedSecretHandle>(&secret);
  DDS_Security_ParticipantSecurityAttributes participant{};
  DDS_Security_EndpointSecurityAttributes endpoint{};
};

/// Writes `count` octets of value 7.
auto write(std::size_t count) {
  return [count](auto&&... arguments) -> Result<std::size_t> {
    MutableBytes room = std::get<sizeof...(arguments) - 1>(std::tie(arguments...));
    if (count > room.size()) return fail(Code::length_out_of_range);
    std::fill_n(room.begin(), count, 7);
    return count;
  };
}

TEST_F(CryptographyAdapterTest, TablesAreComplete) {
  EXPECT_EQ(harness.adapter.gv, harness.domain());
  const auto complete = [](const void* table, int functions) {
    const auto* begin = static_cast<void* const*>(table);
    return std::all_of(begin, begin + functions, [](auto* p) { return p != nullptr; });
  };
  EXPECT_TRUE(complete(factory, 9));
  EXPECT_TRUE(complete(exchange, 7));
  EXPECT_TRUE(complete(transform, 9));
}

TEST_F(CryptographyAdapterTest, Registration) {
  EXPECT_CALL(engine, register_local_participant(spi::IdentityHandle{1}, spi::PermissionsHandle{2},
                                                 spi::PropertyList{}, _))
      .WillOnce(Return(spi::ParticipantCryptoHandle{10}));
  EXPECT_EQ(factory->register_local_participant(factory, 1, 2, nullptr, &participant, nullptr), 10);

  EXPECT_CALL(engine, register_matched_remote_participant(spi::ParticipantCryptoHandle{10},
                                                          spi::IdentityHandle{3},
                                                          spi::PermissionsHandle{4}, _))
      .WillOnce([](auto, auto, auto, const spi::SharedSecret& given) {
        EXPECT_EQ(given.secret.size(), 32u);
        EXPECT_EQ(given.challenge1[0], 1);
        EXPECT_EQ(given.challenge2[0], 2);
        return spi::ParticipantCryptoHandle{11};
      });
  EXPECT_EQ(factory->register_matched_remote_participant(factory, 10, 3, 4, secret_handle, nullptr),
            11);

  std::string name = "dds.sec.crypto.keysize", value = "128";
  DDS_Security_Property_t property{name.data(), value.data(), 1};
  const DDS_Security_PropertySeq properties{1, 1, &property};
  endpoint.is_payload_protected = 1;
  endpoint.plugin_endpoint_attributes =
      spi::kMaskIsValid | DDS_SECURITY_PLUGIN_ENDPOINT_ATTRIBUTES_FLAG_IS_PAYLOAD_ENCRYPTED;
  const spi::EndpointSecurityAttributes encrypted{.topic = {},
                                                  .payload = spi::ProtectionKind::encrypt};
  EXPECT_CALL(engine, register_local_datawriter(spi::ParticipantCryptoHandle{10},
                                                spi::PropertyList{{name, value}}, encrypted))
      .WillOnce(Return(spi::DatawriterCryptoHandle{20}));
  EXPECT_EQ(factory->register_local_datawriter(factory, 10, &properties, &endpoint, nullptr), 20);
  EXPECT_CALL(engine, register_local_datareader(spi::ParticipantCryptoHandle{10}, _, encrypted))
      .WillOnce(Return(spi::DatareaderCryptoHandle{21}));
  EXPECT_EQ(factory->register_local_datareader(factory, 10, &properties, &endpoint, nullptr), 21);
  EXPECT_CALL(engine, register_matched_remote_datareader(spi::DatawriterCryptoHandle{20},
                                                         spi::ParticipantCryptoHandle{11}, _, true))
      .WillOnce(Return(spi::DatareaderCryptoHandle{30}));
  EXPECT_EQ(factory->register_matched_remote_datareader(factory, 20, 11, secret_handle, 1, nullptr),
            30);
  EXPECT_CALL(engine, register_matched_remote_datawriter(spi::DatareaderCryptoHandle{21},
                                                         spi::ParticipantCryptoHandle{11}, _))
      .WillOnce(Return(spi::DatawriterCryptoHandle{31}));
  EXPECT_EQ(factory->register_matched_remote_datawriter(factory, 21, 11, secret_handle, nullptr),
            31);
}

/// Sets a variable for one test.
struct Variable {
  Variable(const char* name, const std::string& value) : name(name) {
    setenv(name, value.c_str(), 1);
  }
  ~Variable() { unsetenv(name); }
  const char* name;
};

TEST_F(CryptographyAdapterTest, AParticipantsPropertiesComeFromTheEnvironment) {
  const auto file = testing::TempDir() + "ddssec-cyclonedds.properties";
  std::ofstream(file)
      << "dds.sec.crypto.symmetric_cipher_algorithm = AES128+GCM\ndds.sec.crypto.keysize = 128\n";
  const auto registers_with = [&](const spi::PropertyList& expected) {
    EXPECT_CALL(engine, register_local_participant(_, _, expected, _))
        .WillOnce(Return(spi::ParticipantCryptoHandle{10}));
    EXPECT_EQ(factory->register_local_participant(factory, 1, 2, nullptr, &participant, nullptr),
              10);
  };
  const spi::Property other{"dds.sec.crypto.keysize", "128", false};
  const auto cipher = [](std::string name) {
    return spi::Property{"dds.sec.crypto.symmetric_cipher_algorithm", std::move(name), false};
  };
  {
    const Variable from(spi::kPropertiesVariable, file);
    registers_with({cipher("AES128+GCM"), other});
    const Variable over(spi::kCipherVariable, "org.ddssec.ChaCha20-Poly1305");
    registers_with({other, cipher("org.ddssec.ChaCha20-Poly1305")});
  }
  {
    const Variable over(spi::kCipherVariable, "AUTO");
    registers_with({cipher("AUTO")});
    const Variable nothing(spi::kPropertiesVariable, "");
    registers_with({cipher("AUTO")});
  }
  const Variable missing(spi::kPropertiesVariable, file + ".not-there");
  EXPECT_EQ(factory->register_local_participant(factory, 1, 2, nullptr, &participant, &refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::file_not_found);
}

TEST_F(CryptographyAdapterTest, RegistrationRefusesNullAndForeignSecrets) {
  EXPECT_EQ(factory->register_local_participant(factory, 1, 2, nullptr, nullptr, &refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::null_argument);
  EXPECT_EQ(factory->register_local_datawriter(factory, 1, nullptr, nullptr, nullptr), 0);
  EXPECT_EQ(factory->register_local_datareader(factory, 1, nullptr, nullptr, nullptr), 0);
  Refusal foreign;
  EXPECT_EQ(factory->register_matched_remote_participant(factory, 1, 2, 3, 0, &foreign), 0);
  EXPECT_EQ(foreign.reason(), Code::foreign_shared_secret);
  EXPECT_EQ(factory->register_matched_remote_datareader(factory, 1, 2, 0, 0, nullptr), 0);
  EXPECT_EQ(factory->register_matched_remote_datawriter(factory, 1, 2, 0, nullptr), 0);
  EXPECT_EQ(factory->register_local_participant(nullptr, 1, 2, nullptr, &participant, nullptr), 0);
}

TEST_F(CryptographyAdapterTest, NilHandlesOfUnprotectedEndpointsAreUnregistered) {
  EXPECT_CALL(engine, unregister_participant(spi::ParticipantCryptoHandle{1}))
      .WillOnce(Return(Status{}));
  EXPECT_CALL(engine, unregister_datawriter(spi::DatawriterCryptoHandle{1}))
      .WillOnce(Return(fail(Code::malformed)));
  EXPECT_CALL(engine, unregister_datareader(spi::DatareaderCryptoHandle{1}))
      .WillOnce(Return(Status{}));
  for (const auto handle : {0, 1}) {
    EXPECT_EQ(factory->unregister_participant(factory, handle, nullptr), 1);
    EXPECT_EQ(factory->unregister_datawriter(factory, handle, nullptr), handle == 0);
    EXPECT_EQ(factory->unregister_datareader(factory, handle, nullptr), 1);
  }
}

TEST_F(CryptographyAdapterTest, CryptoTokensOutAndIn) {
  const std::vector<spi::Token> two = {sample_token(), {.class_id = "second"}};
  ON_CALL(engine, create_local_participant_crypto_tokens).WillByDefault(Return(two));
  ON_CALL(engine, create_local_datawriter_crypto_tokens).WillByDefault(Return(two));
  ON_CALL(engine, create_local_datareader_crypto_tokens)
      .WillByDefault(Return(std::vector<spi::Token>{}));
  const auto is_two = testing::Truly(
      [&](std::span<const spi::Token> tokens) { return std::ranges::equal(tokens, two); });
  EXPECT_CALL(engine, set_remote_participant_crypto_tokens(_, _, is_two))
      .WillOnce(Return(Status{}));
  EXPECT_CALL(engine, set_remote_datawriter_crypto_tokens(spi::DatareaderCryptoHandle{3},
                                                          spi::DatawriterCryptoHandle{4}, is_two))
      .WillOnce(Return(Status{}));
  EXPECT_CALL(engine, set_remote_datareader_crypto_tokens(spi::DatawriterCryptoHandle{4},
                                                          spi::DatareaderCryptoHandle{3}, is_two))
      .WillOnce(Return(fail(Code::malformed)));

  DDS_Security_CryptoTokenSeq tokens{};
  ASSERT_EQ(exchange->create_local_participant_crypto_tokens(exchange, &tokens, 1, 2, nullptr), 1);
  ASSERT_EQ(tokens._length, 2u);
  EXPECT_EQ(exchange->set_remote_participant_crypto_tokens(exchange, 1, 2, &tokens, nullptr), 1);
  EXPECT_EQ(exchange->set_remote_datawriter_crypto_tokens(exchange, 3, 4, &tokens, nullptr), 1);
  EXPECT_EQ(exchange->set_remote_datareader_crypto_tokens(exchange, 4, 3, &tokens, &refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::malformed);
  EXPECT_EQ(exchange->return_crypto_tokens(exchange, &tokens, nullptr), 1);
  EXPECT_EQ(exchange->return_crypto_tokens(exchange, &tokens, nullptr), 1);
  EXPECT_EQ(exchange->return_crypto_tokens(exchange, nullptr, nullptr), 1);

  ASSERT_EQ(exchange->create_local_datareader_crypto_tokens(exchange, &tokens, 1, 2, nullptr), 1);
  EXPECT_EQ(tokens._length, 0u);
  EXPECT_EQ(tokens._buffer, nullptr);
  ASSERT_EQ(exchange->create_local_datawriter_crypto_tokens(exchange, &tokens, 1, 2, nullptr), 1);
  exchange->return_crypto_tokens(exchange, &tokens, nullptr);

  EXPECT_EQ(exchange->create_local_participant_crypto_tokens(exchange, nullptr, 1, 2, nullptr), 0);
  EXPECT_EQ(exchange->set_remote_participant_crypto_tokens(exchange, 1, 2, nullptr, nullptr), 0);
  EXPECT_EQ(exchange->return_crypto_tokens(nullptr, &tokens, nullptr), 0);
}

// Cyclone DDS does so when several participants end at once, and logs each refusal.
TEST_F(CryptographyAdapterTest, AHandleThatIsReturnedTwiceIsNoError) {
  EXPECT_CALL(engine, unregister_datawriter)
      .WillOnce(Return(Status{}))
      .WillOnce(Return(fail(Code::crypto_handle_unknown)))
      .WillOnce(Return(fail(Code::crypto_handle_wrong_kind)));
  auto* const keys = factory;
  EXPECT_EQ(keys->unregister_datawriter(keys, 3, &refusal), 1);
  EXPECT_EQ(keys->unregister_datawriter(keys, 3, &refusal), 1);
  EXPECT_TRUE(harness.events.empty());
  EXPECT_EQ(keys->unregister_datawriter(keys, 3, &refusal), 0);
}

// Of a participant's tokens that are refused, Cyclone DDS frees none and logs each.
TEST_F(CryptographyAdapterTest, RefusedParticipantTokensAreToldOnceAndTakenFromTheHost) {
  EXPECT_CALL(engine, set_remote_participant_crypto_tokens)
      .WillOnce(Return(fail(Code::keys_already_set)))
      .WillOnce(Return(fail(Code::crypto_handle_unknown)));
  const std::vector<spi::Token> one = {sample_token()};
  ON_CALL(engine, create_local_participant_crypto_tokens).WillByDefault(Return(one));
  DDS_Security_CryptoTokenSeq tokens{};
  ASSERT_EQ(exchange->create_local_participant_crypto_tokens(exchange, &tokens, 1, 2, nullptr), 1);
  EXPECT_EQ(exchange->set_remote_participant_crypto_tokens(exchange, 1, 2, &tokens, &refusal), 1);
  ASSERT_EQ(harness.events.size(), 1u);
  EXPECT_EQ(harness.events[0].error.code(), Code::keys_already_set);
  EXPECT_EQ(exchange->set_remote_participant_crypto_tokens(exchange, 1, 2, &tokens, &refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::crypto_handle_unknown);

  const auto length = std::exchange(tokens._length, spi::kMaxTokensPerMessage + 1);
  EXPECT_EQ(exchange->set_remote_participant_crypto_tokens(exchange, 1, 2, &tokens, nullptr), 1);
  EXPECT_EQ(harness.events.back().error.code(), Code::length_out_of_range);
  tokens._length = length;
  exchange->return_crypto_tokens(exchange, &tokens, nullptr);
}

TEST_F(CryptographyAdapterTest, PayloadIsOneBlockWithinItsBound) {
  const HostOctets plain(Bytes(64, 1));
  EXPECT_CALL(engine, encode_serialized_payload(spi::DatawriterCryptoHandle{4}, _, _))
      .WillOnce([](auto, BytesView octets, MutableBytes room) -> Result<std::size_t> {
        EXPECT_EQ(octets.size(), 64u);
        EXPECT_EQ(room.size(), 64 + spi::protection_overhead(0));
        return 108;
      });
  HostBlock encoded;
  EXPECT_EQ(transform->encode_serialized_payload(transform, &encoded, nullptr, &plain.sequence, 4,
                                                 nullptr),
            1);
  EXPECT_EQ(encoded._length, 108u);

  EXPECT_CALL(engine, decode_serialized_payload)
      .WillOnce([](auto, auto, BytesView octets, MutableBytes room) -> Result<std::size_t> {
        EXPECT_LE(room.size(), octets.size());
        return 64;
      })
      .WillOnce(Return(fail(Code::malformed)))
      .WillOnce(Return(65u + 64u));  // more than there was room for
  for (const bool succeeds : {true, false, false}) {
    HostBlock decoded;
    EXPECT_EQ(transform->decode_serialized_payload(transform, &decoded, &plain.sequence, nullptr, 3,
                                                   4, nullptr),
              succeeds);
    EXPECT_EQ(decoded._buffer != nullptr, succeeds);
    EXPECT_EQ(decoded._length, succeeds ? 64u : 0u);
  }
}

TEST_F(CryptographyAdapterTest, AllReceiversInTheFirstCall) {
  const HostOctets plain(Bytes(64, 1));
  DDS_Security_long_long handles[] = {5, 0, 6};
  const DDS_Security_LongLongSeq list{3, 3, handles};
  const auto receive = [](auto, auto receivers, BytesView, MutableBytes room) {
    EXPECT_THAT(receivers,
                ElementsAre(testing::Field("value", &spi::DatareaderCryptoHandle::value, 5),
                            testing::Field("value", &spi::DatareaderCryptoHandle::value, 6)));
    EXPECT_EQ(room.size(), 64 + spi::protection_overhead(2));
    return Result<std::size_t>(128u);
  };
  EXPECT_CALL(engine, encode_datawriter_submessage(spi::DatawriterCryptoHandle{4}, _, _, _))
      .WillOnce(receive);
  HostBlock submessage;
  DDS_Security_long index = 0;
  EXPECT_EQ(transform->encode_datawriter_submessage(transform, &submessage, &plain.sequence, 4,
                                                    &list, &index, nullptr),
            1);
  EXPECT_EQ(index, 3);
  EXPECT_EQ(submessage._length, 128u);

  EXPECT_CALL(engine, encode_rtps_message(_, testing::SizeIs(2), _, _)).WillOnce(write(100));
  HostBlock message;
  index = 0;
  EXPECT_EQ(transform->encode_rtps_message(transform, &message, &plain.sequence, 4, &list, &index,
                                           nullptr),
            1);
  EXPECT_EQ(index, 3);

  EXPECT_CALL(engine, encode_datareader_submessage(_, testing::SizeIs(0), _, _))
      .WillOnce(write(100));
  HostBlock acknack;
  EXPECT_EQ(transform->encode_datareader_submessage(transform, &acknack, &plain.sequence, 4,
                                                    nullptr, nullptr),
            1);
}

TEST_F(CryptographyAdapterTest, AFailedEncodeLeavesNothingAndTheIndexAlone) {
  const HostOctets plain(Bytes(64, 1));
  EXPECT_CALL(engine, encode_rtps_message).WillOnce(Return(fail(Code::malformed)));
  DDS_Security_long_long handles[] = {5};
  const DDS_Security_LongLongSeq list{1, 1, handles};
  HostBlock message;
  DDS_Security_long index = 0;
  EXPECT_EQ(transform->encode_rtps_message(transform, &message, &plain.sequence, 4, &list, &index,
                                           &refusal),
            0);
  EXPECT_EQ(index, 0);
  EXPECT_EQ(message._buffer, nullptr);
  EXPECT_EQ(refusal.reason(), Code::malformed);

  // The later calls of the host's loop would bring no octets; they are never needed.
  const DDS_Security_OctetSeq nothing{};
  EXPECT_EQ(
      transform->encode_rtps_message(transform, &message, &nothing, 4, &list, &index, nullptr), 0);
}

TEST_F(CryptographyAdapterTest, HeaderPrefixReachesTheEngineInWireOrder) {
  Bytes wire(40, 0);
  for (std::uint8_t i = 0; i < 40; ++i) wire[i] = i;
  auto as_received = wire;  // as Cyclone leaves it: the three words of the prefix in machine order
  if constexpr (std::endian::native == std::endian::little)
    for (int word = 8; word < 20; word += 4)
      std::reverse(as_received.begin() + word, as_received.begin() + word + 4);
  const HostOctets message(as_received);
  EXPECT_CALL(engine, decode_rtps_message)
      .WillOnce([&](auto, auto, BytesView octets, MutableBytes room) -> Result<std::size_t> {
        EXPECT_TRUE(std::ranges::equal(octets, wire));
        std::ranges::copy(octets.first(20), room.begin());
        return 20;
      });
  HostBlock decoded;
  EXPECT_EQ(transform->decode_rtps_message(transform, &decoded, &message.sequence, 1, 2, nullptr),
            1);
  EXPECT_EQ(message.octets, as_received) << "the host's buffer is as it was";
  EXPECT_TRUE(std::ranges::equal(decoded.octets(), Bytes(wire.begin(), wire.begin() + 20)));

  const HostOctets tiny(Bytes(19, 1));
  EXPECT_CALL(engine, decode_rtps_message).WillOnce(Return(fail(Code::truncated)));
  HostBlock none;
  EXPECT_EQ(transform->decode_rtps_message(transform, &none, &tiny.sequence, 1, 2, &refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::truncated);
}

TEST_F(CryptographyAdapterTest, ReceiverMacsAreCode124AndNoOtherFailureIs) {
  const HostOctets message(Bytes(64, 1));
  const auto decode_failing_with = [&](Code code) {
    EXPECT_CALL(engine, decode_rtps_message).WillOnce(Return(fail(code)));
    HostBlock out;
    Refusal why;
    EXPECT_EQ(transform->decode_rtps_message(transform, &out, &message.sequence, 1, 2, &why), 0);
    EXPECT_EQ(out._buffer, nullptr);
    return why.code;
  };
  EXPECT_EQ(decode_failing_with(Code::receiver_specific_mac_missing), 124);
  EXPECT_EQ(decode_failing_with(Code::receiver_specific_mac_mismatch), 124);
  EXPECT_EQ(decode_failing_with(Code::malformed), static_cast<int>(Code::malformed));
  ASSERT_EQ(harness.events.size(), 3u);
  EXPECT_EQ(harness.events[0].severity, Severity::debug) << "the next participant may be meant";
  EXPECT_NE(harness.events[1].severity, Severity::debug);
}

TEST_F(CryptographyAdapterTest, PreprocessRoutesOrFails) {
  const HostOctets message(Bytes(64, 1));
  using Category = spi::SecureSubmessageCategory;
  EXPECT_CALL(engine, preprocess_secure_submessage(spi::ParticipantCryptoHandle{0},
                                                   spi::ParticipantCryptoHandle{2}, _))
      .WillOnce(Return(spi::SecureSubmessage{Category::datawriter, {7}, {8}}))
      .WillOnce(Return(spi::SecureSubmessage{Category::datareader, {7}, {8}}))
      .WillOnce(Return(spi::SecureSubmessage{Category::info, {}, {}}));
  DDS_Security_DatawriterCryptoHandle writer = -1;
  DDS_Security_DatareaderCryptoHandle reader = -1;
  auto category = DDS_SECURITY_INFO_SUBMESSAGE;
  const auto preprocess = [&](Exception* ex) {
    return transform->preprocess_secure_submsg(transform, &writer, &reader, &category,
                                               &message.sequence, 0, 2, ex);
  };
  EXPECT_EQ(preprocess(nullptr), 1);
  EXPECT_EQ(category, DDS_SECURITY_DATAWRITER_SUBMESSAGE);
  EXPECT_EQ(writer, 7);
  EXPECT_EQ(reader, 8);
  EXPECT_EQ(preprocess(nullptr), 1);
  EXPECT_EQ(category, DDS_SECURITY_DATAREADER_SUBMESSAGE);
  EXPECT_EQ(preprocess(&refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::nothing_to_route);
  EXPECT_EQ(writer, 0);
  EXPECT_EQ(transform->preprocess_secure_submsg(transform, nullptr, &reader, &category,
                                                &message.sequence, 0, 2, nullptr),
            0);
}

TEST_F(CryptographyAdapterTest, DecodedSubmessageFitsWhereTheHostCopiesIt) {
  const HostOctets message(Bytes(100, 1));  // prefix 24, so 76 are left
  EXPECT_CALL(engine, decode_datawriter_submessage)
      .WillOnce(write(76))
      .WillOnce(write(80))
      .WillOnce(write(74));
  HostBlock fits, exceeds, crooked;
  EXPECT_EQ(
      transform->decode_datawriter_submessage(transform, &fits, &message.sequence, 1, 2, nullptr),
      1);
  EXPECT_EQ(fits._length, 76u);
  EXPECT_EQ(transform->decode_datawriter_submessage(transform, &exceeds, &message.sequence, 1, 2,
                                                    &refusal),
            0);
  EXPECT_EQ(refusal.reason(), Code::result_exceeds_buffer);
  EXPECT_EQ(exceeds._buffer, nullptr);
  Refusal not_aligned;
  EXPECT_EQ(transform->decode_datawriter_submessage(transform, &crooked, &message.sequence, 1, 2,
                                                    &not_aligned),
            0);
  EXPECT_EQ(not_aligned.reason(), Code::malformed);

  EXPECT_CALL(engine, decode_datareader_submessage).WillOnce(write(8));
  HostBlock reader;
  EXPECT_EQ(
      transform->decode_datareader_submessage(transform, &reader, &message.sequence, 1, 2, nullptr),
      1);
  const HostOctets prefix_only(Bytes(24, 1));
  Refusal short_one;
  HostBlock none;
  EXPECT_EQ(transform->decode_datareader_submessage(transform, &none, &prefix_only.sequence, 1, 2,
                                                    &short_one),
            0);
  EXPECT_EQ(short_one.reason(), Code::truncated);
}

// The host reads what is only signed in its own buffer, and there it may hold what was hidden.
TEST_F(CryptographyAdapterTest, WhatIsOnlySignedIsWrittenWhereTheHostReceivedIt) {
  EXPECT_CALL(engine, decode_datawriter_submessage).Times(3).WillRepeatedly(write(32));
  const auto received_after = [&](std::uint8_t id, std::size_t size) {
    Bytes octets(size, 1);
    octets[24] = id;
    auto before = octets;
    const DDS_Security_OctetSeq encoded{static_cast<std::uint32_t>(size),
                                        static_cast<std::uint32_t>(size), octets.data()};
    DDS_Security_OctetSeq plain{};
    const bool done =
        transform->decode_datawriter_submessage(transform, &plain, &encoded, 3, 4, nullptr) == 1;
    std::free(plain._buffer);
    if (octets == before) return Bytes();
    EXPECT_TRUE(done);
    EXPECT_TRUE(std::equal(octets.begin(), octets.begin() + 24, before.begin()));
    EXPECT_TRUE(std::equal(octets.begin() + 24 + 32, octets.end(), before.begin() + 24 + 32));
    return Bytes(octets.begin() + 24, octets.begin() + 24 + 32);
  };
  constexpr std::uint8_t kData = 0x15, kSecureBody = 0x30;
  EXPECT_EQ(received_after(kData, 80), Bytes(32, 7));
  EXPECT_TRUE(received_after(kSecureBody, 80).empty());
  EXPECT_TRUE(received_after(kData, 24 + 28).empty()) << "it does not fit";
}

TEST_F(CryptographyAdapterTest, NullArgumentsAreRefusedNotFollowed) {
  const HostOctets plain(Bytes(64, 1));
  const DDS_Security_OctetSeq no_buffer{64, 64, nullptr};
  HostBlock out;
  EXPECT_EQ(transform->encode_serialized_payload(transform, nullptr, nullptr, &plain.sequence, 1,
                                                 &refusal),
            0);
  EXPECT_EQ(refusal.reason(), Code::null_argument);
  EXPECT_EQ(transform->encode_serialized_payload(transform, &out, nullptr, nullptr, 1, nullptr), 0);
  EXPECT_EQ(transform->encode_serialized_payload(transform, &out, nullptr, &no_buffer, 1, nullptr),
            0);
  EXPECT_EQ(transform->decode_serialized_payload(transform, nullptr, &plain.sequence, nullptr, 1, 2,
                                                 nullptr),
            0);
  EXPECT_EQ(transform->decode_rtps_message(transform, nullptr, &plain.sequence, 1, 2, nullptr), 0);
  EXPECT_EQ(transform->decode_rtps_message(transform, &out, nullptr, 1, 2, nullptr), 0);
  EXPECT_EQ(transform->decode_rtps_message(nullptr, &out, &plain.sequence, 1, 2, nullptr), 0);
  EXPECT_EQ(
      transform->decode_datawriter_submessage(transform, nullptr, &plain.sequence, 1, 2, nullptr),
      0);
}

TEST_F(CryptographyAdapterTest, AnEngineThatThrowsDenies) {
  const HostOctets message(Bytes(64, 1));
  ON_CALL(engine, decode_rtps_message).WillByDefault(testing::Throw(std::runtime_error("x")));
  HostBlock out;
  EXPECT_EQ(transform->decode_rtps_message(transform, &out, &message.sequence, 1, 2, &refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::internal);
  EXPECT_EQ(out._buffer, nullptr);
}

}  // namespace
}  // namespace ddssec::cyclonedds
