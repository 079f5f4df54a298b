#include "plugins/cyclonedds/cryptography_adapter.hpp"

#include <algorithm>
#include <stdexcept>

#include "tests/unit/cyclonedds/cryptography_adapters.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds::cryptography_adapters {
namespace {

TEST_F(CryptographyAdapterTest, Tables_AreComplete) {
  EXPECT_EQ(harness.adapter.gv, harness.domain());
  const auto complete = [](const void* table, int functions) {
    const auto* begin = static_cast<void* const*>(table);
    return std::all_of(begin, begin + functions, [](auto* p) { return p != nullptr; });
  };
  EXPECT_TRUE(complete(factory, 9));
  EXPECT_TRUE(complete(exchange, 7));
  EXPECT_TRUE(complete(transform, 9));
}

TEST_F(CryptographyAdapterTest, NullArguments_AreRefusedNotFollowed) {
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

TEST_F(CryptographyAdapterTest, PluginThatThrows_Denies) {
  const HostOctets message(Bytes(64, 1));
  ON_CALL(plugin, decode_rtps_message).WillByDefault(testing::Throw(std::runtime_error("x")));
  HostBlock out;
  EXPECT_EQ(transform->decode_rtps_message(transform, &out, &message.sequence, 1, 2, &refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::internal);
  EXPECT_EQ(out._buffer, nullptr);
}

}  // namespace
}  // namespace ddssec::cyclonedds::cryptography_adapters
