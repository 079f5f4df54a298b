// The header of a message.
#include "wire/header.hpp"

#include "tests/unit/rtps/wire_helpers.hpp"
#include "wire/info_source.hpp"

namespace ddssec::rtps {
namespace {

using testing::code_of;
using testing::message;
using testing::view_of;
using testing::written;

TEST(Message, Header_NamesUsByOneConstant) {
  const auto octets = message({});
  const auto header = read_header(octets);
  ASSERT_TRUE(header);
  EXPECT_EQ(header->vendor.to_string(), "01d5");
  EXPECT_EQ(header->version, kProtocolVersion);
}

TEST(Message, OtherProtocolsAndVersions_AreRefused) {
  auto octets = message({});
  octets[0] = 'X';
  EXPECT_EQ(code_of(MessageReader::open(octets)), Code::rtps_not_a_message);
  octets = message({});
  octets[4] = 1;
  EXPECT_EQ(code_of(MessageReader::open(octets)), Code::rtps_version_unsupported);
  auto source = written(InfoSource{});
  source[8] = 3;
  EXPECT_EQ(code_of(read_info_source(view_of(source))), Code::rtps_version_unsupported);
}

}  // namespace
}  // namespace ddssec::rtps
