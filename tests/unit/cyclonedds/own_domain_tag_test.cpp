// A domain tag in Cyclone DDS's configuration. The core shows it in the data of a handshake only.
#include "plugins/cyclonedds/own_domain_tag.hpp"

#include "plugins/cyclonedds/authentication_adapter.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds {
namespace {

// PID_VENDORID, the parameters in `between`, and the sentinel.
Bytes data_with(const Bytes& between) {
  Bytes out = {0x00, 0x16, 0, 4, 1, 0x10, 0, 0};
  out.insert(out.end(), between.begin(), between.end());
  out.insert(out.end(), {0, 1, 0, 0});
  return out;
}
const Bytes kTag = {0x40, 0x14, 0, 12, 0, 0, 0, 5, 'l', 'a', 'b', '1', 0, 0, 0, 0};

TEST(OwnDomainTag, Tag_IsRefusedWithTheNameOfTheSetting) {
  const auto status = check_no_domain_tag(data_with(kTag));
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code(), Code::domain_not_covered);
  EXPECT_EQ(status.error().details().field, "<Discovery><Tag>");
  EXPECT_EQ(status.error().details().found, "lab1");
}

TEST(OwnDomainTag, TagThatCannotBeRead_IsRefused) {
  EXPECT_FALSE(check_no_domain_tag(data_with({0x40, 0x14, 0, 4, 0xff, 0xff, 0xff, 0xff})));
  EXPECT_FALSE(check_no_domain_tag(data_with({0x40, 0x14, 0, 0})));
}

TEST(OwnDomainTag, DataWithoutOne_IsTaken) {
  EXPECT_TRUE(check_no_domain_tag(data_with({})));
  EXPECT_TRUE(check_no_domain_tag({}));
}

TEST(OwnDomainTag, HandshakeOfATaggedParticipant_NeverReachesAuthentication) {
  Harness<AuthenticationAdapter, MockAuthentication, spi::Authentication> harness;
  auto* c = static_cast<dds_security_authentication*>(&harness.adapter);
  EXPECT_CALL(*harness.plugin, begin_handshake_request).Times(0);
  EXPECT_CALL(*harness.plugin, begin_handshake_reply).Times(0);
  HostOctets data{data_with(kTag)};
  DDS_Security_DataHolder request{}, out{};
  ASSERT_TRUE(copy_token(sample_token(), request));
  DDS_Security_HandshakeHandle handle = 0;
  Refusal refusal;
  EXPECT_EQ(c->begin_handshake_request(c, &handle, &out, 1, 2, &data.sequence, &refusal),
            DDS_SECURITY_VALIDATION_FAILED);
  EXPECT_EQ(refusal.reason(), Code::domain_not_covered);
  ASSERT_EQ(harness.events.size(), 1u);
  EXPECT_EQ(harness.events.front().error.details().field, "<Discovery><Tag>");
  refusal.clear();
  EXPECT_EQ(c->begin_handshake_reply(c, &handle, &out, &request, 2, 1, &data.sequence, &refusal),
            DDS_SECURITY_VALIDATION_FAILED);
  EXPECT_EQ(refusal.reason(), Code::domain_not_covered);
  EXPECT_EQ(handle, DDS_SECURITY_HANDLE_NIL);
  free_token(request);
}

}  // namespace
}  // namespace ddssec::cyclonedds
