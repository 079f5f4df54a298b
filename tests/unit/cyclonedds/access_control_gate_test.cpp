// Questions of cryptography to access control about a match.
#include "plugins/cyclonedds/access_control_gate.hpp"

#include "plugins/cyclonedds/access_control_adapter.hpp"
#include "plugins/cyclonedds/endpoint_scope.hpp"
#include "tests/support/code_of.hpp"
#include "tests/unit/cyclonedds/access_control_adapters.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds::access_control_adapters {
namespace {

using test::code_of;
using testing::_;
using testing::Return;

using Handle = spi::PermissionsHandle;

// Access control describes an endpoint, and cryptography passes this description on with its
// question.
TEST_F(AccessControlAdapterTest, Cryptography_AsksAboutTheEndpointItself) {
  spi::EndpointSecurityAttributes endpoint;
  endpoint.topic.is_read_protected = true;
  endpoint.payload = ProtectionKind::encrypt;
  ON_CALL(plugin, datareader_sec_attributes).WillByDefault([&](auto&&...) { return endpoint; });
  std::string first = "p", second = "q", tag = "colour", value = "red";
  char* names[] = {first.data(), second.data()};
  const DDS_Security_PartitionQosPolicy partition{{2, 2, names}};
  DDS_Security_Tag tag_of_it{tag.data(), value.data()};
  const DDS_Security_DataTags tags{{1, 1, &tag_of_it}};
  DDS_Security_EndpointSecurityAttributes attributes{};
  ASSERT_EQ(
      c->get_datareader_sec_attributes(c, 8, "Square", &partition, &tags, &attributes, nullptr), 1);
  const auto gate = AccessControlGate::of(attributes.ac_endpoint_properties);
  ASSERT_TRUE(gate && *gate);
  EXPECT_EQ(c->return_datareader_sec_attributes(c, &attributes, nullptr), 1);
  EXPECT_FALSE(is_scope(attributes.ac_endpoint_properties));
  EXPECT_EQ(c->return_datareader_sec_attributes(c, &attributes, nullptr), 1);  // once is enough

  const auto scope = scope_of(harness.adapter.id());
  const AccessControlGate asks(scope, AccessControlAdapter::judge);
  const GuidPrefix prefix{{1, 2, 3}};
  EXPECT_CALL(plugin, check_remote_match(Handle{9}, _))
      .WillOnce([&](Handle, const spi::AccessControl::Match& match) -> Status {
        EXPECT_TRUE(match.remote_writes);
        EXPECT_EQ(match.remote, prefix);
        EXPECT_EQ(match.local.topic_name, "Square");
        EXPECT_EQ(match.local.partitions.size(), 2u);
        EXPECT_EQ(match.local.partitions[1], "q");
        EXPECT_EQ(match.local.data_tags.size(), 1u);
        EXPECT_EQ(match.local.data_tags[0].value, "red");
        return {};
      })
      .WillOnce(Return(fail(Code::match_not_permitted)));
  EXPECT_TRUE(asks.check({{9}, prefix, true}));
  EXPECT_EQ(code_of(asks.check({{9}, {}, false})), Code::keys_not_permitted);
  ASSERT_EQ(harness.events.size(), 1u);
  EXPECT_EQ(harness.events[0].error.code(), Code::match_not_permitted);
}

}  // namespace
}  // namespace ddssec::cyclonedds::access_control_adapters
