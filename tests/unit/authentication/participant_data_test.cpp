#include "plugins/authentication/participant_data.hpp"

#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

TEST(ParticipantData, GuidAmongOtherParameters_IsFound) {
  const auto found = participant_guid_in(participant_data(candidate(7)));
  ASSERT_OK(found);
  EXPECT_EQ(*found, candidate(7));
}

TEST(ParticipantData, MissingSentinelAndRepetition_AreTolerated) {
  Bytes data = participant_data(candidate(7));
  data.resize(data.size() - 4);
  EXPECT_TRUE(participant_guid_in(data));
  const Bytes twice = [&] {
    Bytes all = data;
    all.insert(all.end(), data.begin(), data.end());
    return all;
  }();
  EXPECT_TRUE(participant_guid_in(twice));
}

// Returns a parameter with an RTPS Locator_t.
Bytes locator(std::uint16_t id, std::int32_t kind, std::uint32_t port,
              std::initializer_list<std::uint8_t> end) {
  Writer writer;
  writer.write(id);
  writer.write(std::uint16_t{24});
  writer.write(kind);
  writer.write(port);
  Bytes address(16, 0);
  std::ranges::copy(end, address.end() - static_cast<std::ptrdiff_t>(end.size()));
  writer.write_bytes(address);
  return writer.take();
}

TEST(ParticipantData, UnicastAddressesOfDiscovery_AreFound) {
  constexpr std::uint16_t kMetatrafficUnicast = 0x32, kDefaultUnicast = 0x31;
  const auto addresses_in = [](std::initializer_list<Bytes> parameters) {
    Bytes data;
    for (const auto& one : parameters) data.insert(data.end(), one.begin(), one.end());
    const auto rest = participant_data(candidate(7));
    data.insert(data.end(), rest.begin(), rest.end());
    return addresses_in_participant_data(data);
  };
  const auto good = locator(kMetatrafficUnicast, 1, 7410, {10, 0, 0, 1});
  const auto found = addresses_in({good, good});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_FALSE(found[0].is_ipv6);
  EXPECT_EQ(found[0].port, 7410);
  EXPECT_EQ(to_hex(BytesView(found[0].address).subspan(12)), "0a000001");
  EXPECT_TRUE(addresses_in({}).empty());
  for (const auto& bad : {locator(kDefaultUnicast, 1, 7410, {10, 0, 0, 1}),
                          locator(kMetatrafficUnicast, 4, 7410, {10, 0, 0, 1}),  // TCP
                          locator(kMetatrafficUnicast, 1, 0, {10, 0, 0, 1}),     // no port
                          // This one has no port either.
                          locator(kMetatrafficUnicast, 1, 0x11cf2, {10, 0, 0, 1}),
                          locator(kMetatrafficUnicast, 1, 7410, {0, 0, 0, 0}),      // no address
                          locator(kMetatrafficUnicast, 1, 7410, {239, 255, 0, 1}),  // multicast
                          locator(kMetatrafficUnicast, 1, 7410, {255, 255, 255, 255})})
    EXPECT_TRUE(addresses_in({bad}).empty());
  EXPECT_TRUE(addresses_in({locator(kMetatrafficUnicast, 2, 7410, {1})}).at(0).is_ipv6);
  EXPECT_EQ(addresses_in({locator(kMetatrafficUnicast, 1, 1, {10, 0, 0, 1}),
                          locator(kMetatrafficUnicast, 1, 2, {10, 0, 0, 1}),
                          locator(kMetatrafficUnicast, 1, 3, {10, 0, 0, 1}),
                          locator(kMetatrafficUnicast, 1, 4, {10, 0, 0, 1}),
                          locator(kMetatrafficUnicast, 1, 5, {10, 0, 0, 1})})
                .size(),
            kMaxAddresses);
}

TEST(ParticipantData, BuiltinEndpointSet_IsReadOnceOnly) {
  const auto set_in = [](BytesView begin) {
    auto data = to_bytes(begin);
    const auto rest = participant_data(candidate(7));
    data.insert(data.end(), rest.begin(), rest.end());
    return builtin_endpoints_in_participant_data(data);
  };
  const Bytes one = {0, 0x58, 0, 4, 0x0f, 0x3f, 0x0c, 0x3f};
  Bytes two = one;
  two.insert(two.end(), one.begin(), one.end());
  EXPECT_EQ(set_in(one), 0x0f3f0c3fu);
  EXPECT_EQ(set_in(two), 0u);
  EXPECT_EQ(set_in({}), 0u);
  EXPECT_EQ(set_in(Bytes{0, 0x58, 0, 2, 0x0f, 0x3f}), 0u);
}

TEST(ParticipantData, MalformedList_IsRefused) {
  const Bytes one = participant_data(candidate(7));
  Bytes two = one;
  two.resize(two.size() - 4);
  const Bytes other = participant_data(candidate(8));
  two.insert(two.end(), other.begin(), other.end());
  EXPECT_CODE(participant_guid_in(two), participant_data_malformed);
  EXPECT_CODE(participant_guid_in(Bytes{0, 0x50, 0, 8, 1, 2, 3, 4, 5, 6, 7, 8}),
              participant_data_malformed);
  EXPECT_CODE(participant_guid_in(Bytes{0, 0x50, 0, 16, 1}), participant_data_malformed);
  EXPECT_CODE(participant_guid_in(Bytes{0, 0x50, 0}), participant_data_malformed);
  EXPECT_CODE(participant_guid_in(Bytes{}), participant_guid_missing);
  EXPECT_CODE(participant_guid_in(Bytes{0, 1, 0, 0}), participant_guid_missing);
}

TEST(ParticipantData, LengthThatIsNoMultipleOfFour_IsRefused) {
  for (const std::uint8_t length : {1, 2, 3, 5, 6}) {
    Bytes data = {0, 0x62, 0, length};
    data.resize(data.size() + length, 'a');
    const auto rest = participant_data(candidate(7));
    data.insert(data.end(), rest.begin(), rest.end());
    EXPECT_CODE(participant_guid_in(data), participant_data_malformed);
  }
}

TEST(ParticipantData, PadAndVendorParameters_AreSkipped) {
  Bytes data = {0, 0, 0, 4, 9, 9, 9, 9, 0x80, 0x07, 0, 4, 1, 2, 3, 4};
  const auto rest = participant_data(candidate(7));
  data.insert(data.end(), rest.begin(), rest.end());
  EXPECT_EQ(participant_guid_in(data), candidate(7));
  // A PAD may also be the last parameter of a list without sentinel.
  data.resize(data.size() - 4);
  data.insert(data.end(), {0, 0, 0, 0});
  EXPECT_EQ(participant_guid_in(data), candidate(7));
}

TEST(ParticipantData, EveryTruncation_IsRefusedOrHarmless) {
  const Bytes whole = participant_data(candidate(7));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto found = participant_guid_in(BytesView(whole).first(size));
    if (found) {
      EXPECT_EQ(*found, candidate(7)) << size;
    }
  }
}

TEST(IdentityToken, TokenInParticipantData_SaysWhatCounts) {
  Token token{"DDS:Auth:PKI-DH:1.0"};
  token.properties.push_back({"org.ddssec.symmetric_ciphers", "org.ddssec.ChaCha20-Poly1305"});
  const auto data = participant_data(candidate(7), &token);
  EXPECT_EQ(ciphers_in_participant_data(data), spi::kAllCiphers);
  EXPECT_EQ(ciphers_in_participant_data(participant_data(candidate(7))), spi::kStandardCiphers);
  EXPECT_EQ(ciphers_in_participant_data({}), spi::kStandardCiphers);
  // Two parameters, or half of one, announce nothing.
  auto twice = data;
  twice.resize(twice.size() - 4);
  twice.insert(twice.end(), data.begin(), data.end());
  EXPECT_EQ(ciphers_in_participant_data(twice), spi::kStandardCiphers);
  for (std::size_t size = 0; size < data.size(); ++size) {
    const auto seen = ciphers_in_participant_data(BytesView(data).first(size));
    EXPECT_TRUE(seen == spi::kStandardCiphers || seen == spi::kAllCiphers) << size;
  }
}

}  // namespace
}  // namespace ddssec::authentication
