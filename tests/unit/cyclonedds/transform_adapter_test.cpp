// Calls in which the host has messages encoded and decoded.
#include <algorithm>
#include <cstdlib>

#include "plugins/cyclonedds/cryptography_adapter.hpp"
#include "tests/unit/cyclonedds/cryptography_adapters.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds::cryptography_adapters {
namespace {

using testing::_;
using testing::ElementsAre;
using testing::Return;

// Writes `count` octets of value 7.
auto write(std::size_t count) {
  return [count](auto&&... arguments) -> Result<std::size_t> {
    MutableBytes room = std::get<sizeof...(arguments) - 1>(std::tie(arguments...));
    if (count > room.size()) return fail(Code::length_out_of_range);
    std::fill_n(room.begin(), count, 7);
    return count;
  };
}

TEST_F(CryptographyAdapterTest, Payload_IsOneBlockWithinItsBound) {
  const HostOctets plain(Bytes(64, 1));
  EXPECT_CALL(plugin, encode_serialized_payload(spi::DatawriterCryptoHandle{4}, _, _))
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

  EXPECT_CALL(plugin, decode_serialized_payload)
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

TEST_F(CryptographyAdapterTest, AllReceivers_AreInTheFirstCall) {
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
  EXPECT_CALL(plugin, encode_datawriter_submessage(spi::DatawriterCryptoHandle{4}, _, _, _))
      .WillOnce(receive);
  HostBlock submessage;
  DDS_Security_long index = 0;
  EXPECT_EQ(transform->encode_datawriter_submessage(transform, &submessage, &plain.sequence, 4,
                                                    &list, &index, nullptr),
            1);
  EXPECT_EQ(index, 3);
  EXPECT_EQ(submessage._length, 128u);

  EXPECT_CALL(plugin, encode_rtps_message(_, testing::SizeIs(2), _, _)).WillOnce(write(100));
  HostBlock message;
  index = 0;
  EXPECT_EQ(transform->encode_rtps_message(transform, &message, &plain.sequence, 4, &list, &index,
                                           nullptr),
            1);
  EXPECT_EQ(index, 3);

  EXPECT_CALL(plugin, encode_datareader_submessage(_, testing::SizeIs(0), _, _))
      .WillOnce(write(100));
  HostBlock acknack;
  EXPECT_EQ(transform->encode_datareader_submessage(transform, &acknack, &plain.sequence, 4,
                                                    nullptr, nullptr),
            1);
}

TEST_F(CryptographyAdapterTest, AFailedEncode_LeavesNothingAndTheIndexAlone) {
  const HostOctets plain(Bytes(64, 1));
  EXPECT_CALL(plugin, encode_rtps_message).WillOnce(Return(fail(Code::malformed)));
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

  // The later calls of the host's loop would bring no octets, and are not needed.
  const DDS_Security_OctetSeq nothing{};
  EXPECT_EQ(
      transform->encode_rtps_message(transform, &message, &nothing, 4, &list, &index, nullptr), 0);
}

TEST_F(CryptographyAdapterTest, HeaderPrefix_ReachesThePluginInWireOrder) {
  Bytes wire(40, 0);
  for (std::uint8_t i = 0; i < 40; ++i) wire[i] = i;
  auto as_received = wire;  // Cyclone leaves the three words of the prefix in machine order
  if constexpr (std::endian::native == std::endian::little)
    for (int word = 8; word < 20; word += 4)
      std::reverse(as_received.begin() + word, as_received.begin() + word + 4);
  const HostOctets message(as_received);
  EXPECT_CALL(plugin, decode_rtps_message)
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
  EXPECT_CALL(plugin, decode_rtps_message).WillOnce(Return(fail(Code::truncated)));
  HostBlock none;
  EXPECT_EQ(transform->decode_rtps_message(transform, &none, &tiny.sequence, 1, 2, &refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::truncated);
}

TEST_F(CryptographyAdapterTest, ReceiverMacs_AreCode124AndNoOtherFailureIs) {
  const HostOctets message(Bytes(64, 1));
  const auto decode_failing_with = [&](Code code) {
    EXPECT_CALL(plugin, decode_rtps_message).WillOnce(Return(fail(code)));
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

TEST_F(CryptographyAdapterTest, Preprocess_RoutesOrFails) {
  const HostOctets message(Bytes(64, 1));
  using Category = spi::SecureSubmessageCategory;
  EXPECT_CALL(plugin, preprocess_secure_submessage(spi::ParticipantCryptoHandle{0},
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

TEST_F(CryptographyAdapterTest, DecodedSubmessage_FitsWhereTheHostCopiesIt) {
  const HostOctets message(Bytes(100, 1));  // the prefix takes 24 octets, so 76 are left
  EXPECT_CALL(plugin, decode_datawriter_submessage)
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

  EXPECT_CALL(plugin, decode_datareader_submessage).WillOnce(write(8));
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

// The host reads a submessage that is only signed from its own buffer. What the plugin hid in the
// plaintext must be hidden there, too.
TEST_F(CryptographyAdapterTest, WhatIsOnlySigned_IsWrittenWhereTheHostReceivedIt) {
  EXPECT_CALL(plugin, decode_datawriter_submessage).Times(3).WillRepeatedly(write(32));
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

}  // namespace
}  // namespace ddssec::cyclonedds::cryptography_adapters
