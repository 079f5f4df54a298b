#include "rtps/security/generic_message.hpp"

#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using testing::code_of;

Guid guid(std::uint8_t octet, EntityId entity) {
  return {GuidPrefix::from(Bytes(12, octet)), entity};
}

GenericMessage example() {
  GenericMessage message;
  message.identity = {guid(1, kStatelessMessageWriter), 7};
  message.related = {guid(2, kStatelessMessageWriter), 5};
  message.destination_participant = guid(2, kEntityIdParticipant);
  message.destination_endpoint = guid(2, {{0, 0, 1, 0x07}});
  message.source_endpoint = guid(1, {{0, 0, 2, 0x02}});
  message.message_class = message_class::kAuthentication;
  message.data = {{"class", {{"a", "b"}}, {{"c", {1, 2, 3}}}}, {"other", {}, {}}};
  return message;
}

TEST(GenericMessage, WrittenMessage_ComesBackAsItWas) {
  const auto octets = write_generic_message(example());
  // These are the offsets after the encapsulation (authentication-discovery reference, section 2).
  EXPECT_EQ(octets[1], 1);
  EXPECT_EQ(octets[4 + 16], 7);
  EXPECT_EQ(octets[4 + 40], 5);
  EXPECT_EQ(octets[4 + 96], 13);
  EXPECT_EQ(as_text(BytesView(octets).subspan(4 + 100, 12)), "dds.sec.auth");
  const auto read = read_generic_message(octets);
  ASSERT_TRUE(read);
  EXPECT_EQ(*read, example());
}

TEST(GenericMessage, EveryTruncation_IsRefused) {
  const auto octets = write_generic_message(example());
  // The padding at the end may be missing.
  for (std::size_t size = 0; size + 4 < octets.size(); ++size)
    EXPECT_FALSE(read_generic_message(BytesView(octets).first(size))) << size;
}

TEST(GenericMessage, HugeCounts_AreRefusedBeforeAnythingIsAllocated) {
  auto message = example();
  message.data.clear();
  auto octets = write_generic_message(message);
  for (std::size_t i = 0; i < 4; ++i) octets[octets.size() - 1 - i] = 0xff;
  EXPECT_EQ(code_of(read_generic_message(octets)), Code::length_out_of_range);
  message.data.resize(spi::kMaxTokensPerMessage + 1);
  EXPECT_EQ(code_of(read_generic_message(write_generic_message(message))),
            Code::length_out_of_range);
}

TEST(GenericMessage, OtherEncapsulations_AreRefused) {
  auto octets = write_generic_message(example());
  octets[1] = 3;
  EXPECT_EQ(code_of(read_generic_message(octets)), Code::rtps_encapsulation_unsupported);
}

}  // namespace
}  // namespace ddssec::rtps
