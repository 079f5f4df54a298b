#include "plugins/cryptography/receiver_places.hpp"

#include <gtest/gtest.h>

#include "plugins/cryptography/key_material.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kOriginAuthenticated = ProtectionKind::encrypt_with_origin_authentication;
constexpr auto kShare = ReceiverPlaces::share_of(ReceiverPlaces::kMax);
constexpr auto kShareOfEach = ReceiverPlaces::share_of(ReceiverPlaces::kMaxOfEach);
constexpr std::size_t kMaxInDatagram = 65507;

// A writer with readers of remote participants that have several certificates.
struct CrowdedWriter {
  explicit CrowdedWriter(ProtectionKind rtps = ProtectionKind::none) {
    side.participant = side.factory()
                           .register_local_participant({1}, {1}, {}, participant_attributes(rtps))
                           .value();
    writer = side.factory()
                 .register_local_datawriter(
                     side.participant, {},
                     endpoint_attributes(kOriginAuthenticated, ProtectionKind::none))
                 .value();
  }
  // Matches a participant. `session` distinguishes one authentication from the next.
  Result<ParticipantCryptoHandle> meet(std::uint8_t certificate, std::uint16_t number,
                                       std::uint8_t session = 1) {
    auto secret = shared_secret(session);
    const auto high = static_cast<std::uint8_t>(number >> 8),
               low = static_cast<std::uint8_t>(number);
    if (certificate != 0)
      secret.peer_prefix = GuidPrefix{{0x80, certificate, 0, 0, 0, 0, 0, 0, 0, 0, high, low}};
    return side.factory().register_matched_remote_participant(
        side.participant, {10000 * certificate + number}, {7}, secret);
  }
  ParticipantCryptoHandle participant(std::uint8_t certificate, std::uint16_t number) {
    return meet(certificate, number).value();
  }
  // Matches participants until one is refused.
  std::vector<ParticipantCryptoHandle> participants_of(std::uint8_t certificate) {
    std::vector<ParticipantCryptoHandle> all;
    for (std::uint16_t number = 1;; ++number) {
      const auto one = meet(certificate, number);
      if (!one) return all;
      all.push_back(*one);
    }
  }
  // Announces a reader, as a stranger can in the participant's name where discovery is not
  // protected.
  Result<DatareaderCryptoHandle> announce_reader(ParticipantCryptoHandle of) {
    return side.factory().register_matched_remote_datareader(writer, of, shared_secret(), false);
  }
  Status give_tokens(DatareaderCryptoHandle reader) {
    KeyMaterial material{.kind = kAes256Gcm};
    const Bytes octets(32, 0x77);
    const auto id = ++keys;
    material.salt = MasterSalt::copy_of(octets).value();
    material.sender_key = MasterKey::copy_of(octets).value();
    material.sender_key_id = {{1, static_cast<std::uint8_t>(id >> 16),
                               static_cast<std::uint8_t>(id >> 8), static_cast<std::uint8_t>(id)}};
    material.receiver_key_id = {{2, 0, 0, 1}};
    material.receiver_key = MasterReceiverKey::copy_of(octets).value();
    const auto token = crypto_token(material);
    return side.exchange().set_remote_datareader_crypto_tokens(writer, reader, {&token, 1});
  }
  Result<DatareaderCryptoHandle> reader(ParticipantCryptoHandle of) {
    DDSSEC_ASSIGN_OR_RETURN(const auto added, announce_reader(of));
    DDSSEC_RETURN_IF_ERROR(give_tokens(added));
    readers.push_back(added);
    return added;
  }
  // Adds readers until one is refused. Returns their number.
  std::size_t readers_of(ParticipantCryptoHandle participant) {
    std::size_t count = 0;
    while (reader(participant)) ++count;
    return count;
  }
  Result<Bytes> message() {
    const auto data = data_submessage(1400);
    return into_bytes(
        data.size() + spi::protection_overhead(readers.size()), [&](MutableBytes out) {
          return side.transform().encode_datawriter_submessage(writer, readers, data, out);
        });
  }
  Result<Bytes> rtps_message_for(std::span<const ParticipantCryptoHandle> receivers,
                                 const Bytes& submessage) {
    const auto plain = rtps_message({submessage});
    return into_bytes(
        plain.size() + spi::protection_overhead(receivers.size()), [&](MutableBytes out) {
          return side.transform().encode_rtps_message(side.participant, receivers, plain, out);
        });
  }

  Side side{{.host_checks_sources = false}};
  DatawriterCryptoHandle writer;
  std::vector<DatareaderCryptoHandle> readers;
  std::uint32_t keys = 0;
};

TEST(ReceiverPlaces, OneCertificate_HasItsShareForAllItsParticipants) {
  CrowdedWriter writer;
  const auto first = writer.participant(1, 1), second = writer.participant(1, 2);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(writer.reader(first));
  EXPECT_EQ(writer.readers_of(second), kShare - 100);
  EXPECT_EQ(code_of(writer.reader(first)), Code::receiver_places_taken);
  EXPECT_EQ(writer.side.events.codes(), std::vector(2, Code::receiver_places_taken));
  EXPECT_TRUE(writer.reader(writer.participant(2, 1))) << "others are served";
  ASSERT_TRUE(writer.side.factory().unregister_datareader(writer.readers.front()));
  EXPECT_TRUE(writer.reader(first));
  EXPECT_EQ(code_of(writer.reader(first)), Code::receiver_places_taken);
  ASSERT_TRUE(writer.side.factory().unregister_participant(second));
  EXPECT_EQ(writer.readers_of(first), kShare - 100);
}

// Only the participant itself has the tokens of its readers.
TEST(ReceiverPlaces, ReadersThatAStrangerInvented_TakeNone) {
  CrowdedWriter writer;
  const auto participant = writer.participant(1, 1);
  const auto invented = writer.announce_reader(participant).value();
  for (std::size_t i = 0; i < 2 * kShare; ++i)
    ASSERT_TRUE(writer.announce_reader(participant)) << i;
  EXPECT_EQ(writer.readers_of(participant), kShare);
  EXPECT_EQ(code_of(writer.give_tokens(invented)), Code::receiver_places_taken);
  ASSERT_TRUE(writer.side.factory().unregister_datareader(invented));
  EXPECT_EQ(code_of(writer.reader(participant)), Code::receiver_places_taken) << "it had none";
}

TEST(ReceiverPlaces, ReaderWhoseTokensComeOften_TakesOne) {
  CrowdedWriter writer;
  const auto participant = writer.participant(1, 1);
  const auto first = writer.reader(participant).value();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(code_of(writer.give_tokens(first)), Code::keys_already_set);
  EXPECT_EQ(writer.readers_of(participant), kShare - 1);
}

TEST(ReceiverPlaces, AReaderWhoseTokensAreRefused_TakesNone) {
  CrowdedWriter writer;
  const auto participant = writer.participant(1, 1);
  const auto broken = writer.announce_reader(participant).value();
  EXPECT_EQ(code_of(writer.side.exchange().set_remote_datareader_crypto_tokens(writer.writer,
                                                                               broken, {})),
            Code::crypto_token_count);
  EXPECT_EQ(writer.readers_of(participant), kShare);
}

// If further readers had places, the writer could not send to any reader.
TEST(ReceiverPlaces, AllOfThem_FitIntoOneDatagram) {
  constexpr std::size_t kRtpsHeaderAndTimestamp = 20 + 16 + 12;
  CrowdedWriter writer;
  for (std::uint8_t certificate = 1; certificate <= 5; ++certificate)
    EXPECT_EQ(writer.readers_of(writer.participant(certificate, 1)), kShare);
  EXPECT_EQ(code_of(writer.reader(writer.participant(6, 1))), Code::receiver_places_taken);
  const auto message = writer.message();
  ASSERT_TRUE(message);
  EXPECT_LE(message->size() + kRtpsHeaderAndTimestamp, kMaxInDatagram);
}

TEST(ReceiverPlaces, AllOfBothLevels_FitIntoOneDatagram) {
  CrowdedWriter writer(kOriginAuthenticated);
  std::vector<ParticipantCryptoHandle> all;
  for (std::uint8_t certificate = 1; certificate <= 5; ++certificate)
    for (const auto one : writer.participants_of(certificate)) {
      all.push_back(one);
      ASSERT_TRUE(writer.reader(one));
    }
  EXPECT_EQ(all.size(), ReceiverPlaces::kMaxOfEach);
  EXPECT_EQ(code_of(writer.reader(all.front())), Code::receiver_places_taken);
  EXPECT_EQ(code_of(writer.meet(6, 1)), Code::receiver_places_taken);
  const auto submessage = writer.message();
  ASSERT_TRUE(submessage);
  const auto message = writer.rtps_message_for(all, *submessage);
  ASSERT_TRUE(message);
  EXPECT_LE(message->size(), kMaxInDatagram);
}

TEST(ReceiverPlaces, OneCertificate_HasItsShareOfParticipantsWithMacs) {
  CrowdedWriter writer(kOriginAuthenticated);
  const auto all = writer.participants_of(1);
  EXPECT_EQ(all.size(), kShareOfEach);
  EXPECT_EQ(writer.side.events.codes(), std::vector{Code::receiver_places_taken});
  EXPECT_NE(writer.side.events.last().find("participants"), std::string::npos)
      << writer.side.events.last();
  EXPECT_TRUE(writer.meet(2, 1)) << "others are served";
  ASSERT_TRUE(writer.side.factory().unregister_participant(all.front()));
  EXPECT_TRUE(writer.meet(1, 2000));
  EXPECT_FALSE(writer.meet(1, 2001));
  EXPECT_EQ(writer.readers_of(all.back()), kShareOfEach) << "each of them may have a reader";
}

TEST(ReceiverPlaces, AParticipantThatAuthenticatesAnew_KeepsItsPlace) {
  CrowdedWriter writer(kOriginAuthenticated);
  const auto all = writer.participants_of(1);
  EXPECT_EQ(writer.meet(1, 1), all.front()) << "asked again";
  EXPECT_EQ(writer.meet(1, 1, 2), all.front()) << "in a new session";
  EXPECT_FALSE(writer.meet(1, 2000));
  ASSERT_TRUE(writer.side.factory().unregister_participant(all.front()));
  EXPECT_TRUE(writer.meet(1, 2000));
  EXPECT_FALSE(writer.meet(1, 2001));
}

// In this case participants add no octets to a message.
TEST(ReceiverPlaces, ParticipantsWithoutOriginAuthentication_NeedNoPlace) {
  CrowdedWriter writer(ProtectionKind::encrypt);
  for (std::uint16_t number = 1; number <= ReceiverPlaces::kMaxOfEach + 1; ++number)
    ASSERT_TRUE(writer.meet(1, number));
}

// Beside a stock authentication plugin the certificate is unknown. All participants have places
// nevertheless.
TEST(ReceiverPlaces, ParticipantsWithoutAProvenName_ShareAllPlaces) {
  CrowdedWriter writer(kOriginAuthenticated);
  EXPECT_EQ(writer.participants_of(0).size(), ReceiverPlaces::kMaxOfEach);
}

// The host lists the receivers first, and has the message encoded for them later. One of them may
// leave in between.
TEST(ReceiverPlaces, OneThatHasLeft_DoesNotCostTheOthersTheMessage) {
  CrowdedWriter writer(kOriginAuthenticated);
  const std::vector stay = {writer.participant(1, 1), writer.participant(2, 1)};
  const auto gone = writer.participant(3, 1);
  for (const auto one : {stay[0], gone, stay[1]}) ASSERT_TRUE(writer.reader(one));
  const auto of_three = writer.message().value();
  const auto all = std::vector{stay[0], gone, stay[1]};
  const auto for_three = writer.rtps_message_for(all, of_three).value();
  ASSERT_TRUE(writer.side.factory().unregister_participant(gone));
  constexpr std::size_t kMac = 20;
  const auto of_two = writer.message();
  ASSERT_TRUE(of_two);
  EXPECT_EQ(of_two->size(), of_three.size() - kMac);
  const auto for_two = writer.rtps_message_for(all, of_three);
  ASSERT_TRUE(for_two);
  EXPECT_EQ(for_two->size(), for_three.size() - kMac);
  EXPECT_EQ(code_of(writer.rtps_message_for({{gone}}, of_three)), Code::crypto_handle_unknown);
}

TEST(ReceiverPlaces, ReadersWithoutOriginAuthentication_NeedNoPlace) {
  CrowdedWriter writer;
  writer.writer = writer.side.factory()
                      .register_local_datawriter(
                          writer.side.participant, {},
                          endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none))
                      .value();
  const auto participant = writer.participant(1, 1);
  for (std::size_t i = 0; i <= kShare; ++i) ASSERT_TRUE(writer.reader(participant));
}

}  // namespace
}  // namespace ddssec::cryptography::testing
