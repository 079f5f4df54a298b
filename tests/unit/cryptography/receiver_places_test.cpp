#include "plugins/cryptography/receiver_places.hpp"

#include <gtest/gtest.h>

#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kOriginAuthenticatedWriter = ProtectionKind::encrypt_with_origin_authentication;

/// A writer that remote participants of several certificates have readers for.
struct CrowdedWriter {
  CrowdedWriter() {
    side.participant =
        side.factory()
            .register_local_participant({1}, {1}, {}, participant_attributes(ProtectionKind::none))
            .value();
    writer = side.factory()
                 .register_local_datawriter(
                     side.participant, {},
                     endpoint_attributes(kOriginAuthenticatedWriter, ProtectionKind::none))
                 .value();
  }
  ParticipantCryptoHandle participant(std::uint8_t certificate, std::uint8_t number) {
    auto secret = shared_secret(certificate);
    secret.peer_prefix = GuidPrefix{{0x80, certificate, 0, 0, 0, 0, 0, 0, 0, 0, 0, number}};
    return side.factory()
        .register_matched_remote_participant(side.participant, {1000 * certificate + number}, {7},
                                             secret)
        .value();
  }
  Result<DatareaderCryptoHandle> reader(ParticipantCryptoHandle of) {
    auto added =
        side.factory().register_matched_remote_datareader(writer, of, shared_secret(), false);
    if (added) readers.push_back(*added);
    return added;
  }
  /// As many as are admitted.
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

  Side side{{.host_checks_sources = false}};
  DatawriterCryptoHandle writer;
  std::vector<DatareaderCryptoHandle> readers;
};

TEST(ReceiverPlaces, OneCertificateHasItsShareHoweverManyParticipantsItHas) {
  CrowdedWriter writer;
  const auto first = writer.participant(1, 1), second = writer.participant(1, 2);
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(writer.reader(first));
  EXPECT_EQ(writer.readers_of(second), ReceiverPlaces::kMostOfSubject - 100);
  EXPECT_EQ(code_of(writer.reader(first)), Code::receiver_count);
  EXPECT_EQ(writer.side.events.codes, std::vector(2, Code::receiver_count));
  EXPECT_TRUE(writer.reader(writer.participant(2, 1))) << "others are served";
  ASSERT_TRUE(writer.side.factory().unregister_datareader(writer.readers.front()));
  EXPECT_TRUE(writer.reader(first));
  EXPECT_FALSE(writer.reader(first));
  ASSERT_TRUE(writer.side.factory().unregister_participant(second));
  EXPECT_EQ(writer.readers_of(first), ReceiverPlaces::kMostOfSubject - 100);
}

/// Further ones would end the writer for all.
TEST(ReceiverPlaces, AllOfThemFitIntoOneDatagram) {
  constexpr std::size_t kMostInDatagram = 65507, kRtpsHeaderAndTimestamp = 20 + 16 + 12;
  CrowdedWriter writer;
  for (std::uint8_t certificate = 1; certificate <= 5; ++certificate)
    EXPECT_EQ(writer.readers_of(writer.participant(certificate, 1)),
              ReceiverPlaces::kMostOfSubject);
  EXPECT_EQ(code_of(writer.reader(writer.participant(6, 1))), Code::receiver_count);
  const auto message = writer.message();
  ASSERT_TRUE(message);
  EXPECT_LE(message->size() + kRtpsHeaderAndTimestamp, kMostInDatagram);
}

TEST(ReceiverPlaces, AreForOriginAuthenticationOnly) {
  CrowdedWriter writer;
  writer.writer = writer.side.factory()
                      .register_local_datawriter(
                          writer.side.participant, {},
                          endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none))
                      .value();
  const auto participant = writer.participant(1, 1);
  for (std::size_t i = 0; i <= ReceiverPlaces::kMostOfSubject; ++i)
    ASSERT_TRUE(writer.reader(participant));
}

}  // namespace
}  // namespace ddssec::cryptography::testing
